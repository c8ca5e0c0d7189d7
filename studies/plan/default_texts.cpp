#include "studies/plan/default_texts.h"

#include <fmt/format.h>

namespace crowdbench::studies {
namespace {

// What the answers of a task are called in a sentence.
std::string ways_to_answer(const StudyPlan& plan) {
  switch (plan.task) {
    case Task::forced_choice:
      return "Choose the **upper** or the **lower** crowd. Where you are not sure, choose the one that is more likely: "
             "there is no third answer, and guessing is fine.";
    case Task::preference:
      return "Choose the **upper** or the **lower** crowd, or say that you **cannot tell**. None of the answers is "
             "wrong: we want to know what you see.";
    case Task::same_different:
      return "Say whether the two crowds are drawn the **same** way or **differently**. In about half of the clips "
             "they "
             "are drawn the same way.";
  }
  return {};
}

}  // namespace

std::string default_question(Question question, Task task) {
  if (task == Task::same_different) return "Are the two crowds drawn the same way?";
  switch (question) {
    case Question::better: return "Which crowd looks better?";
    case Question::differs: return "In which crowd did something look wrong?";
    case Question::pop: return "In which crowd did somebody change all of a sudden?";
  }
  return {};
}

std::string default_consent() {
  return R"(# Taking part

In this study you watch short clips of computer-animated crowds and answer one question after each of them.

- Taking part is voluntary. You can stop at any time, without a reason and without any disadvantage, and you can have your
  answers deleted.
- What is kept: your answers to the clips and to the questions, how long they took, the size of your screen and window as they
  are measured, what your browser calls itself, and how smoothly the clips played. Your name and your address on the network
  are not kept.
- Nothing in the clips is meant to startle or upset. There is movement in all of them; should it make you feel unwell, stop.

*Whoever runs this study: put your name and address here, who has approved it, for how long the data are kept and who gets
them, before you invite anybody.*

By going on you say that you have read this and want to take part.
)";
}

std::string default_instructions(const StudyPlan& plan) {
  return fmt::format(R"(# What to do

Each clip shows two crowds, one above the other, with a bar between them. It lasts {} seconds. Look at both, then answer:

**{}**

{}

{}.{}

Please sit as you usually do, at an arm's length from the screen, in a room without glare, and stay at that distance. Do not
zoom, and leave other windows closed: clips that stutter cannot be used.
)",
                     plan.stimulus.seconds, plan.question_text, ways_to_answer(plan),
                     plan.stimulus.replays == 0 ? std::string("Each clip is shown once")
                     : plan.stimulus.replays == 1
                         ? std::string("Each clip may be watched once more")
                         : fmt::format("Each clip may be watched again, up to {} times", plan.stimulus.replays),
                     plan.training > 0 ? " The first clips are for practice: their answers do not count." : "");
}

std::string default_debrief() {
  return R"(# Thank you

Crowds in games and films are often drawn in a cheaper way where they are far off. In some of the clips one half was drawn
in full and the other half in such a way; in a few both halves were the same, or one was spoilt on purpose, to see whether
the answers can be relied on. Your answers help to find out from where on nobody sees the difference.

If you want your answers to be deleted, use the button on this page, or write to whoever invited you.
)";
}

}  // namespace crowdbench::studies
