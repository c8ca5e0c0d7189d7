// A scenario's representation, made: where it does not go with the characters, who chose it is told.
#pragma once
#include <functional>
#include <memory>

#include "bench/commands/scene_options.h"
#include "core/error.h"
#include "renderers/representation.h"

namespace crowdbench::bench {

// What of an error is of the chosen representation's options (it names the type, or one of its components) is thrown
// again as of "FILE:LINE: `representation`" or of the option that chose it; anything else as it is. To be called where
// `error` is caught.
[[noreturn]] void blame_choice(const ChosenScenario& chosen, const Error& error);

// make_representation() of the chosen one.
std::unique_ptr<renderers::Representation> make_chosen(const ChosenScenario& chosen,
                                                       const renderers::MakeContext& context,
                                                       const renderers::Spec& spec);

}  // namespace crowdbench::bench
