#include "bench/commands/chosen_representation.h"

namespace crowdbench::bench {

void blame_choice(const ChosenScenario& chosen, const Error& error) {
  if (!error.where.starts_with("representation '")) throw;
  throw Error(chosen.representation_from, error.where + ": " + error.wrong, error.advice);
}

std::unique_ptr<renderers::Representation> make_chosen(const ChosenScenario& chosen,
                                                       const renderers::MakeContext& context,
                                                       const renderers::Spec& spec) {
  try {
    return renderers::make_representation(context, spec);
  } catch (const Error& error) {
    blame_choice(chosen, error);
  }
}

}  // namespace crowdbench::bench
