// What participants read where a plan names no files of its own: Markdown.
#pragma once
#include <string>

#include "studies/plan/plan.h"

namespace crowdbench::studies {

std::string default_question(Question question, Task task);
std::string default_consent();
std::string default_instructions(const StudyPlan& plan);
std::string default_debrief();

}  // namespace crowdbench::studies
