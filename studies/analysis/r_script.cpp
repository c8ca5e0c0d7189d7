#include "studies/analysis/r_script.h"

#include <fmt/format.h>

#include "studies/analysis/text_numbers.h"

namespace crowdbench::studies {
namespace {

// A string of R's, and of CSV in quotes.
std::string quoted(const std::string& text, char escape) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '\n') {
      out += escape == '\\' ? "\\n" : "\n";
      continue;
    }
    if (c == '"' || (c == '\\' && escape == '\\')) out += escape;
    out += c;
  }
  return out + "\"";
}

// A name as the exported tables have it.
std::string name(const std::string& text, char escape) { return quoted(text::spreadsheet_safe(text), escape); }

constexpr const char* kHead =
    R"R(# The mixed models of `crowdbench study analyze`, by lme4. Run in this folder: Rscript analysis.R
library(lme4)
answers <- read.csv("data/study_answers_data.csv", colClasses = "character", na.strings = character(0))
for (column in c("task", "condition")) if (is.null(answers[[column]])) answers[[column]] <- ""
for (column in intersect(c("chosen", "decided", "level"), names(answers))) answers[[column]] <- suppressWarnings(as.numeric(answers[[column]]))
answers <- answers[answers$decided > 0, ]
# Trials with nothing to see are false alarms and no part of the models.
if (!is.null(answers$signal)) answers <- answers[answers$signal != "0", ]
ours <- read.csv("estimates.csv", colClasses = c("character", "character", "character", "numeric", "numeric"),
                 na.strings = character(0))
furthest <- 0

# P(yes) = guess + (1 - guess) F(eta)
guessing <- function(guess, link) {
  base <- make.link(link)
  if (guess == 0) return(base)
  inner <- function(mu) pmin(pmax((mu - guess) / (1 - guess), 1e-9), 1 - 1e-9)
  structure(list(linkfun = function(mu) base$linkfun(inner(mu)),
                 linkinv = function(eta) guess + (1 - guess) * base$linkinv(eta),
                 mu.eta = function(eta) (1 - guess) * base$mu.eta(eta),
                 valideta = function(eta) TRUE, name = paste0("guess", guess)), class = "link-glm")
}

compare <- function(task, condition, rows, formula, guess, link, nAGQ, effects) {
  cat("\n== task", shQuote(task), "condition", shQuote(condition), "\n")
  # "Cannot tell" that is split gives halves, which lme4 rounds in silence. Twice the counts at half the weight are whole
  # numbers and the same likelihood.
  rows$half <- 0.5
  # Levels in units of their spread about their mean, as crowdbench optimises in; lme4 stops short of the estimate in
  # others. Independent random slopes are of levels about 0: those are in units of their size alone.
  back <- diag(length(effects))
  if ("level" %in% effects) {
    mean_level <- weighted.mean(rows$level, rows$decided)
    spread <- sqrt(weighted.mean((rows$level - mean_level)^2, rows$decided))
    rows$centred <- (rows$level - mean_level) / spread
    rows$scaled <- rows$level / sqrt(weighted.mean(rows$level^2, rows$decided))
    back[1, 2] <- -mean_level / spread
    back[2, 2] <- 1 / spread
  }
  fit <- glmer(formula, data = rows, weights = half, family = binomial(guessing(guess, link)), nAGQ = nAGQ,
               control = glmerControl(optimizer = "bobyqa", optCtrl = list(maxfun = 1e5)))
  estimate <- as.vector(back %*% fixef(fit))
  se <- sqrt(diag(back %*% as.matrix(vcov(fit)) %*% t(back)))
  mine <- ours[ours$task == task & ours$condition == condition, ]
  mine <- mine[match(effects, mine$effect), ]
  table <- data.frame(effect = effects, crowdbench = mine$estimate, lme4 = estimate,
                      crowdbench_se = mine$se, lme4_se = se, row.names = NULL)
  print(table, digits = 6)
  if (any(c("centred", "scaled") %in% names(rows)))
    cat("Variances of slopes are of `centred` (of `scaled`), of intercepts at the levels' mean where slopes correlate.\n")
  print(VarCorr(fit), comp = "Variance")
  furthest <<- max(furthest, abs(table$crowdbench - table$lme4) / table$crowdbench_se)
}

)R";

std::string random_terms(const MixedSettings& s) {
  std::string out = !s.slopes      ? "(1 | participant)"
                    : s.correlated ? "(1 + centred | participant)"
                                   : "(1 + scaled || participant)";
  return out + (s.clips ? " + (1 | clip)" : "");
}

// One model: its rows, formula and settings.
std::string model(const TaskResult& t, const MixedResult& m, const Analysis& a) {
  const bool level = m.effects.size() > 1 && m.effects[1] == "level";
  const size_t first_contrast = level ? 2 : 1;
  std::string rows = fmt::format("rows <- subset(answers, task == {}", name(t.name, '\\'));
  if (!m.condition.empty()) rows += fmt::format(" & condition == {}", name(m.condition, '\\'));
  std::string out = rows + ")\n";
  std::string fixed = level ? "1 + centred" : "1";
  if (m.effects.size() > first_contrast) {
    // The first condition is what the others are held against.
    std::string levels;
    for (const ConditionResult& c : t.conditions)
      levels += fmt::format("{}{}", levels.empty() ? "" : ", ", name(c.name, '\\'));
    out += fmt::format("rows$condition <- factor(rows$condition, levels = c({}))\n", levels);
    fixed += " + condition";
  }
  std::string effects;
  for (const std::string& effect : m.effects)
    effects += fmt::format("{}{}", effects.empty() ? "" : ", ", name(effect, '\\'));
  const int nodes = m.settings.integration == Integration::quadrature ? 25 : 1;
  if (m.settings.integration == Integration::laplace_observed)
    out +=
        "# Laplace here has the observed information, lme4's the expected one: they differ a little where guesses are "
        "held.\n";
  out +=
      fmt::format("compare({}, {}, rows, cbind(2 * chosen, 2 * (decided - chosen)) ~ {} + {}, {}, \"{}\", {}, c({}))\n",
                  name(t.name, '\\'), name(m.condition, '\\'), fixed, random_terms(m.settings), m.settings.guess,
                  m.settings.link == Link::logit ? "logit" : "probit", nodes, effects);
  return out + (a.tasks.size() > 1 ? "\n" : "");
}

}  // namespace

std::string r_script(const Analysis& a) {
  std::string out = kHead;
  for (const TaskResult& t : a.tasks)
    for (const MixedResult& m : t.mixed)
      if (!m.fit.fixed.empty()) out += model(t, m, a);
  return out +
         "\ncat(\"\\nlargest difference of an estimate, in its standard errors:\", format(furthest, digits = 3), "
         "\"\\n\")\n";
}

std::string estimates_csv(const Analysis& a) {
  std::string out = "task,condition,effect,estimate,se\n";
  for (const TaskResult& t : a.tasks)
    for (const MixedResult& m : t.mixed)
      for (size_t i = 0; i < m.fit.fixed.size(); ++i)
        out += fmt::format("{},{},{},{},{}\n", name(t.name, '"'), name(m.condition, '"'), name(m.effects[i], '"'),
                           m.fit.fixed[i].estimate, m.fit.fixed[i].se);
  return out;
}

}  // namespace crowdbench::studies
