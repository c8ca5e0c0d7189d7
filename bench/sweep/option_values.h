// Whether the values of a representation's options are ones that its table of options takes: said when a plan is read,
// before anything is drawn.
#pragma once
#include <string>

#include "renderers/representation.h"

namespace crowdbench::bench::sweep {

// What is wrong with the first value, its components' included, that the table rules out: "option depth=12 of relief is
// not one of 8|16". Empty where none is. Tables say values as words and ranges, "auto|0..16"; what they say in another
// form (a list of names, "LINEAR+BINARY") is left to the bake.
std::string wrong_option_value(const renderers::Spec& spec);

}  // namespace crowdbench::bench::sweep
