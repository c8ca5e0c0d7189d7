#include "studies/analysis/analysis_output.h"
#include "studies/analysis/verdict_sentences.h"

namespace crowdbench::studies {
namespace {

Json json_of(const Interval& i) { return Json::array({i.low, i.high}); }
Json json_of(const LikelihoodRatio& r);
Json json_of(const RankingResult& r);
Json json_of(const ScorePredictions& p);
Json json_of(const Tost& t) { return {{"p", t.p}, {"p_low", t.p_low}, {"p_upp", t.p_upp}}; }
template <typename T>
Json json_of(const std::optional<T>& value) {
  if constexpr (requires { json_of(*value); })
    return value ? json_of(*value) : Json();
  else
    return value ? Json(*value) : Json();
}
Json json_of(const LikelihoodRatio& r) {
  return {{"chi_squared", r.chi_squared}, {"degrees_of_freedom", 1}, {"p", r.p}};
}

Json json_of(const Equivalence& e) {
  return {{"verdict", std::string(verdict_text(e.verdict))},
          {"exact", json_of(e.exact)},
          {"different_exact_p", e.different_exact},
          {"by_participant", json_of(e.by_participant)},
          {"different_by_participant_p", json_of(e.different_by_participant)},
          {"mean_share", e.mean},
          {"interval", json_of(e.interval)},
          {"participant_sd", json_of(e.participant_sd)},
          {"trials_needed", json_of(e.trials_needed)},
          {"participants_needed", json_of(e.participants_needed)},
          {"more_trials", e.more_trials},
          {"more_participants", e.more_participants}};
}

Json json_of(const DifferenceResult& d, const std::vector<ConditionResult>& conditions) {
  const DifferenceEquivalence& e = d.equivalence;
  return {{"first", conditions[d.first].name},
          {"second", conditions[d.second].name},
          {"verdict", std::string(verdict_text(e.verdict))},
          {"difference", e.difference},
          {"score", json_of(e.score)},
          {"different_score_p", e.different_score},
          {"different_p_holm", d.holm},
          {"participants", e.participants},
          {"by_participant", json_of(e.by_participant)},
          {"different_by_participant_p", json_of(e.different_by_participant)},
          {"interval", json_of(e.interval)},
          {"participant_sd", json_of(e.participant_sd)},
          {"trials_needed_of_either", json_of(e.trials_needed)},
          {"participants_needed", json_of(e.participants_needed)},
          {"more_trials_of_either", e.more_trials},
          {"more_participants", e.more_participants}};
}

Json json_of(const ScorePredictions& p) {
  Json out = {{"answers", p.answers},           {"stimuli", p.stimuli},
              {"participants", p.participants}, {"answers_without_scores", p.without_scores},
              {"resamples", p.resamples},       {"best", p.best ? Json(p.scores[*p.best].score) : Json()}};
  out["scores"] = out["contests"] = Json::array();
  for (const ScorePrediction& s : p.scores) {
    Json one = {{"score", s.score}, {"state", std::string(state_text(s.state))}};
    if (s.state == PredictionState::fitted)
      one.update({{"falls", s.falls},
                  {"auc", s.auc},
                  {"auc_interval", json_of(s.auc_interval)},
                  {"calibration_slope", json_of(s.calibration_slope)},
                  {"calibration_slope_interval", json_of(s.slope_interval)},
                  {"calibration_intercept", json_of(s.calibration_intercept)},
                  {"calibration_intercept_interval", json_of(s.intercept_interval)}});
    out["scores"].push_back(one);
  }
  for (const ScoreContest& c : p.contests)
    out["contests"].push_back({{"better", p.scores[c.a].score},
                               {"other", p.scores[c.b].score},
                               {"difference", c.difference},
                               {"interval", json_of(c.interval)},
                               {"distinguishable", c.distinguishable}});
  return out;
}

Json json_of(const SignalDetection& d) {
  return {{"d_prime", d.d_prime},
          {"d_prime_se", d.d_prime_se},
          {"criterion", d.criterion},
          {"criterion_se", d.criterion_se},
          {"corrected", d.corrected}};
}

Json json_of(const ConditionResult& c) {
  Json out = {
      {"condition", c.name}, {"yes", c.yes},        {"ties", c.ties}, {"no", c.no}, {"participants", c.participants},
      {"chosen", c.chosen},  {"decided", c.decided}};
  if (c.decided > 0) {
    out["share"] = static_cast<double>(c.chosen) / static_cast<double>(c.decided);
    out["clopper_pearson"] = json_of(c.exact);
    out["wilson"] = json_of(c.score);
    if (c.is_tested()) {
      out["p_two_sided"] = c.test.two_sided;
      out["p_greater"] = c.test.greater;
      out["p_less"] = c.test.less;
      out["p_holm"] = c.holm;
    }
  } else {
    out["state"] = "no data";
  }
  if (c.equivalence) out["equivalence"] = json_of(*c.equivalence);
  if (c.detection) out["detection"] = json_of(*c.detection);
  return out;
}

Json json_of(const AngleThreshold& a) {
  return {{"at", a.degrees},
          {"interval", Json::array({json_of(a.low), json_of(a.high)})},
          {"calibration_share", a.calibration_share},
          {"participants_calibrated", a.calibrated}};
}

Json json_of(const CurveFit::Ends& e) { return Json::array({json_of(e.low), json_of(e.high)}); }

Json json_of(const CurveResult& c, const CurveSettings& s) {
  Json out = {{"condition", c.condition},
              {"state", std::string(state_text(c.fit.state))},
              {"curve", std::string(curve_name(s.curve))},
              {"falling", s.falling},
              {"answers", c.fit.answers},
              {"levels", c.fit.levels}};
  if (c.fit.state == CurveState::no_data || c.fit.state == CurveState::one_level ||
      c.fit.state == CurveState::all_alike)
    return out;
  out.update({{"location", c.fit.at.location},
              {"scale", c.fit.at.scale},
              {"guess", c.fit.at.guess},
              {"lapse", c.fit.at.lapse},
              {"location_se", json_of(c.fit.location_se)},
              {"scale_se", json_of(c.fit.scale_se)},
              {"negative_log_likelihood", c.fit.negative_log_likelihood},
              {"deviance", c.fit.deviance},
              {"level", s.level},
              {"threshold", json_of(c.fit.threshold)},
              {"location_profile", json_of(c.fit.location_profile)},
              {"threshold_profile", json_of(c.fit.threshold_profile)}});
  if (c.bootstrap)
    out["threshold_bootstrap"] = {{"interval", c.bootstrap->has_interval() ? json_of(c.bootstrap->threshold) : Json()},
                                  {"draws", c.by_participant ? "participants" : "answers from the fitted curve"},
                                  {"resamples", c.bootstrap->resamples},
                                  {"failed", c.bootstrap->failed},
                                  {"widened", c.bootstrap->widened},
                                  {"alike", c.bootstrap->alike},
                                  {"few", c.bootstrap->few},
                                  {"stretch", c.bootstrap->stretch}};
  if (const auto told = threshold_interval(c))
    out["threshold_interval"] = {
        {"interval", told->method.empty() ? Json() : Json::array({json_of(told->low), json_of(told->high)})},
        {"method", told->method.empty() ? Json() : Json(told->method)},
        {"over_clips", told->over_clips},
        {"clips", c.clips > 0 ? Json(c.clips) : Json()},
        {"degrees_of_freedom",
         c.jackknife && c.jackknife->state == JackknifeState::done ? Json(c.jackknife->degrees) : Json()},
        {"why", told->why}};
  if (c.angle) out["threshold_degrees"] = json_of(*c.angle);
  return out;
}

Json json_of(const MixedResult& m) {
  const char* integration = m.settings.integration == Integration::quadrature ? "adaptive Gauss-Hermite, 25 nodes"
                            : m.settings.integration == Integration::laplace  ? "Laplace, expected information"
                                                                              : "Laplace, observed information";
  const Json guess_from = m.guess_from == GuessSource::settings ? Json("settings")
                          : m.guess_from == GuessSource::curve  ? Json("curve")
                                                                : Json();
  Json out = {{"condition", m.condition},
              {"state", std::string(state_text(m.fit.state))},
              {"link", m.settings.link == Link::logit ? "logit" : "probit"},
              {"guess", m.settings.guess},
              {"guess_from", guess_from},
              {"integration", integration},
              {"answers", m.fit.answers},
              {"participants", m.fit.participants}};
  if (m.fit.fixed.empty()) return out;
  out["fixed"] = Json::array();
  for (size_t i = 0; i < m.effects.size(); ++i)
    out["fixed"].push_back({{"effect", m.effects[i]},
                            {"estimate", m.fit.fixed[i].estimate},
                            {"se", m.fit.fixed[i].se},
                            {"z", m.fit.fixed[i].z},
                            {"p", m.fit.fixed[i].p}});
  out.update({{"participant_variance", m.fit.participant_variance},
              {"slope_variance", json_of(m.fit.slope_variance)},
              {"intercept_slope_covariance", json_of(m.fit.intercept_slope_covariance)},
              {"clip_variance", json_of(m.fit.clip_variance)},
              {"log_likelihood", m.fit.log_likelihood},
              {"level_likelihood_ratio", json_of(m.ratio)}});
  if (m.threshold) out["threshold"] = {{"at", m.threshold->at}, {"interval_95", json_of(m.threshold->interval)}};
  if (m.angle) out["threshold_degrees"] = json_of(*m.angle);
  if (m.population) out["population"] = {{"typical", m.population->typical}, {"average", m.population->average}};
  return out;
}

Json json_of(const Jod& jod) {
  return {{"state", std::string(state_text(jod.state))},
          {"jod", jod.q},
          {"se_against_first", jod.se},
          {"negative_log_likelihood", jod.state == WorthState::fitted ? Json(jod.negative_log_likelihood) : Json()}};
}

Json json_of(const RankingResult& r) {
  const Worths& w = r.worths;
  Json out = {{"items", r.items}, {"conditions", r.conditions}, {"state", std::string(state_text(w.state))}};
  out["groups"] = Json::array();
  for (const auto& group : w.groups) {
    Json names = Json::array();
    for (const uint32_t item : group) names.push_back(r.items[item]);
    out["groups"].push_back(names);
  }
  if (w.state == WorthState::fitted)
    out.update({{"log_worth", w.log_worth},
                {"se", w.se},
                {"worth", w.worth},
                {"log_nu", json_of(w.log_nu)},
                {"log_nu_se", json_of(w.log_nu_se)},
                {"position", json_of(w.position)},
                {"position_se", json_of(w.position_se)},
                {"position_likelihood_ratio", json_of(r.position)},
                {"log_likelihood", w.log_likelihood}});
  out["jod"] = json_of(r.jod);
  out["jod_with_prior"] = json_of(r.jod_with_prior);
  if (r.intervals) {
    out["jod_with_prior"]["intervals"] = Json::array();
    for (const Interval& i : r.intervals->q) out["jod_with_prior"]["intervals"].push_back(json_of(i));
    out["jod_with_prior"]["failed_resamples"] = r.intervals->failed;
  }
  return out;
}

Json json_of(const TaskResult& t, const AnalysisSettings& s) {
  Json out = {{"task", t.name}};
  out["conditions"] = out["curves"] = out["mixed_models"] = Json::array();
  for (const ConditionResult& c : t.conditions) out["conditions"].push_back(json_of(c));
  for (const CurveResult& c : t.curves) out["curves"].push_back(json_of(c, s.curve));
  for (const MixedResult& m : t.mixed) out["mixed_models"].push_back(json_of(m));
  out["ranking"] = json_of(t.ranking);
  if (t.side)
    out["side"] = {
        {"yes_stood_first", t.side->first},     {"of", t.side->of},
        {"share_both_alike", t.side->share},    {"chosen_first", t.side->chosen_first},
        {"participants", t.side->participants}, {"interval", t.side->interval ? json_of(*t.side->interval) : Json()}};
  if (!t.differences.empty()) out["differences"] = Json::array();
  for (const DifferenceResult& d : t.differences) out["differences"].push_back(json_of(d, t.conditions));
  if (t.prediction) out["prediction"] = json_of(*t.prediction);
  out["verdicts"] = verdict_sentences(t, s);
  return out;
}

}  // namespace

std::string_view tie_rule_text(TieRule rule) {
  return rule == TieRule::drop ? "drop" : rule == TieRule::split ? "split" : "no";
}

Json analysis_json(const Analysis& a) {
  Json out = {{"sources", a.sources},
              {"rows", a.rows},
              {"participants", a.participants},
              {"simulated_rows", a.simulated_rows},
              {"catch_rows", a.catch_rows}};
  out["excluded"] = Json::array();
  for (const Exclusion& e : a.excluded)
    out["excluded"].push_back({{"participant", e.participant}, {"right", e.right}, {"of", e.of}});
  out["left_out"] = {{"fast", a.left_out.fast},
                     {"dropped", a.left_out.dropped},
                     {"hidden", a.left_out.hidden},
                     {"hidden_catch", a.left_out.hidden_catch}};
  out["asked"] = a.settings.asked.text.empty() ? Json() : Json(a.settings.asked.text);
  out["yes_means"] = a.settings.asked.yes.empty() ? Json() : Json(a.settings.asked.yes);
  out["settings"] = {{"chance", a.settings.chance},
                     {"confidence", a.settings.confidence},
                     {"axis", a.settings.axis.name.empty() ? Json() : Json(a.settings.axis.name)},
                     {"axis_unit", axis_unit(a.settings.axis)},
                     {"ties", std::string(tie_rule_text(a.settings.ties))},
                     {"margin", json_of(a.settings.margin)},
                     {"between", json_of(a.settings.between)},
                     {"alpha", a.settings.alpha},
                     {"power", a.settings.power},
                     {"catch_least", a.settings.catch_least},
                     {"shortest_rt_ms", a.settings.trials.shortest_rt_ms},
                     {"most_frames_dropped", json_of(a.settings.trials.most_frames_dropped)},
                     {"hidden_left_out", a.settings.trials.hidden},
                     {"seed", a.settings.seed},
                     {"resamples", a.settings.resamples}};
  out["tasks"] = Json::array();
  for (const TaskResult& t : a.tasks) out["tasks"].push_back(json_of(t, a.settings));
  return out;
}

}  // namespace crowdbench::studies
