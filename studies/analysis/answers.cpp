#include "studies/analysis/answers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>

#include "core/error.h"
#include "core/screen_calibration.h"

namespace crowdbench::studies {
namespace {

constexpr uint64_t kMostAnswers = 1'000'000'000;
// Sizes of levels: squares of them, and of their differences, are numbers still.
constexpr double kSmallestLevel = 1e-15;
constexpr double kLargestLevel = 1e15;
constexpr double kLargestPixelRatio = 100;  // of a clip's to the screen's, either way

const std::vector<std::pair<std::string, Role>>& role_names() {
  static const std::vector<std::pair<std::string, Role>> all = {{"participant", Role::participant},
                                                                {"trial", Role::trial},
                                                                {"task", Role::task},
                                                                {"condition", Role::condition},
                                                                {"clip", Role::clip},
                                                                {"stimulus", Role::stimulus},
                                                                {"level", Role::level},
                                                                {"signal", Role::signal},
                                                                {"item_a", Role::item_a},
                                                                {"item_b", Role::item_b},
                                                                {"shown_first", Role::shown_first},
                                                                {"answer", Role::answer},
                                                                {"expected", Role::expected},
                                                                {"yes", Role::yes},
                                                                {"no", Role::no},
                                                                {"ties", Role::ties},
                                                                {"total", Role::total},
                                                                {"rt", Role::rt},
                                                                {"frames_dropped", Role::frames_dropped},
                                                                {"hidden", Role::hidden},
                                                                {"study", Role::study},
                                                                {"catch", Role::catch_kind},
                                                                {"pixels_per_degree", Role::pixels_per_degree},
                                                                {"pixels_per_degree_se", Role::pixels_per_degree_se},
                                                                {"css_px_per_clip_px", Role::css_px_per_clip_px},
                                                                {"observers", Role::observers},
                                                                {"yes_first", Role::yes_first}};
  return all;
}

std::vector<std::string> names_of_roles() {
  std::vector<std::string> out;
  for (const auto& [name, role] : role_names()) out.push_back(name);
  return out;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : static_cast<char>(c);
  });
  return text;
}

enum class Word { yes, no, tie, unknown };

Word word_of(const std::string& given) {
  static const std::map<std::string, Word> words = {
      {"yes", Word::yes},         {"1", Word::yes},    {"true", Word::yes},     {"right", Word::yes},
      {"correct", Word::yes},     {"seen", Word::yes}, {"no", Word::no},        {"0", Word::no},
      {"false", Word::no},        {"wrong", Word::no}, {"incorrect", Word::no}, {"unseen", Word::no},
      {"cannot tell", Word::tie}, {"tie", Word::tie},  {"none", Word::tie}};
  const auto found = words.find(lower(given));
  return found == words.end() ? Word::unknown : found->second;
}

// Of two things.
Word choice_of(const std::string& given, const std::string& a, const std::string& b) {
  if (given == a) return Word::yes;
  if (given == b) return Word::no;
  const std::string word = lower(given);
  if (word == "a" || word == "first" || word == "1") return Word::yes;
  if (word == "b" || word == "second" || word == "2") return Word::no;
  return word == "cannot tell" || word == "tie" || word == "none" ? Word::tie : Word::unknown;
}

class Names {
 public:
  explicit Names(std::vector<std::string>& names) : names_(names) {
    for (const std::string& name : names) index_.emplace(name, static_cast<uint32_t>(index_.size()));
  }
  uint32_t of(const std::string& name) {
    const auto [found, added] = index_.emplace(name, static_cast<uint32_t>(names_.size()));
    if (added) names_.push_back(name);
    return found->second;
  }

 private:
  std::vector<std::string>& names_;
  std::unordered_map<std::string, uint32_t> index_;
};

// The columns of one table by role.
class Columns {
 public:
  Columns(const Table& table, const ColumnMap& map) : table_(table) {
    for (const auto& [role, name] : map.columns) {
      const auto found = std::find(table.columns.begin(), table.columns.end(), name);
      if (found == table.columns.end())
        throw Error(table.source + ":1", fmt::format("there is no column '{}'", printable(name)),
                    fmt::format("there are {}", nearest_first(name, table.columns)));
      of_[role].push_back(static_cast<size_t>(found - table.columns.begin()));
    }
    for (const auto& [role, columns] : of_)
      if (columns.size() > 1 && role != Role::condition)
        throw Error(table.source + ":1", fmt::format("two columns are to be `{}`", name(role)), "choose one of them");
    const bool counts = has(Role::yes) && (has(Role::no) || has(Role::total));
    if (has(Role::answer) == counts)
      throw Error(table.source + ":1",
                  counts ? "has both an `answer` and counts of answers" : "has no column that is the answer",
                  "name the column of the answer (answer=NAME), or of counts (yes=NAME,total=NAME)");
    if (has(Role::item_a) != has(Role::item_b))
      throw Error(table.source + ":1", "has one of `item_a` and `item_b`", "a comparison has two items");
    if (has(Role::shown_first) && !has(Role::item_a))
      throw Error(table.source + ":1", "has `shown_first` without `item_a` and `item_b`", "name the two items");
  }
  static std::string name(Role role) {
    for (const auto& [text, each] : role_names())
      if (each == role) return text;
    return "";
  }
  bool has(Role role) const { return of_.contains(role); }
  const std::vector<size_t>& all(Role role) const { return of_.at(role); }
  const std::string& field(const Table::Row& row, Role role) const { return row.fields[of_.at(role)[0]]; }
  std::string where(const Table::Row& row) const { return fmt::format("{}:{}", table_.source, row.line); }

  Error wrong(const Table::Row& row, Role role, const std::string& advice) const {
    const std::string& text = field(row, role);
    const std::string column = printable(table_.columns[of_.at(role)[0]], 60);
    if (text.empty()) return {where(row), fmt::format("column '{}' ({}) is empty", column, name(role)), advice};
    return {where(row),
            fmt::format("'{}' in column '{}' is not what `{}` takes", printable(text, 60), column, name(role)), advice};
  }
  const std::string& required(const Table::Row& row, Role role) const {
    if (field(row, role).empty()) throw wrong(row, role, "every row needs one");
    return field(row, role);
  }
  double number(const Table::Row& row, Role role) const {
    const std::string& text = required(row, role);
    double value = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
      throw wrong(row, role, "it is to be a finite number");
    return value;
  }
  uint64_t count(const Table::Row& row, Role role) const {
    const double value = number(row, role);
    if (value < 0 || value > static_cast<double>(kMostAnswers) || value != std::floor(value))
      throw wrong(row, role, fmt::format("it is to be a whole number from 0 to {}", kMostAnswers));
    return static_cast<uint64_t>(value);
  }

 private:
  const Table& table_;
  std::map<Role, std::vector<size_t>> of_;
};

void read_counts(const Columns& columns, const Table::Row& row, Answer& out) {
  out.yes = columns.count(row, Role::yes);
  if (columns.has(Role::ties)) out.ties = columns.count(row, Role::ties);
  if (columns.has(Role::no)) out.no = columns.count(row, Role::no);
  if (!columns.has(Role::total)) return;
  const uint64_t total = columns.count(row, Role::total);
  if (!columns.has(Role::no)) {
    if (total < out.yes + out.ties)
      throw Error(columns.where(row), fmt::format("{} answers of {} in all", out.yes + out.ties, total),
                  "the total counts every answer");
    out.no = total - out.yes - out.ties;
  }
  if (out.count() != total)
    throw Error(columns.where(row), fmt::format("{} answers of {} in all", out.count(), total),
                "the total counts every answer");
}

Word read_word(const Columns& columns, const Table::Row& row, Role role) {
  const std::string& text = columns.required(row, role);
  if (columns.has(Role::item_a)) {
    const Word word = choice_of(text, columns.field(row, Role::item_a), columns.field(row, Role::item_b));
    if (word == Word::unknown) throw columns.wrong(row, role, "it is one of the two items, a, b, or cannot tell");
    return word;
  }
  return word_of(text);
}

void read_answer(const Columns& columns, const Table::Row& row, Answer& out) {
  Word word = read_word(columns, row, Role::answer);
  if (columns.has(Role::expected) && !columns.has(Role::item_a)) {
    // Any words serve, as long as both columns use the same.
    const std::string& answer = columns.field(row, Role::answer);
    const bool equal = lower(answer) == lower(columns.required(row, Role::expected));
    word = equal ? Word::yes : word == Word::tie ? Word::tie : Word::no;
  }
  if (word == Word::unknown)
    throw columns.wrong(row, Role::answer,
                        "it is yes or no (1 or 0), or cannot tell; other words need expected=COLUMN");
  out.yes = word == Word::yes ? 1 : 0;
  out.no = word == Word::no ? 1 : 0;
  out.ties = word == Word::tie ? 1 : 0;
}

// Of a catch trial with items: whether the answer is the expected one.
void read_catch(const Columns& columns, const Table::Row& row, Answer& out) {
  const std::string& kind = columns.field(row, Role::catch_kind);
  const std::string word = lower(kind);
  if (word.empty() || word == "0" || word == "no" || word == "none" || word == "false") return;
  out.catch_kind = kind;
  if (!columns.has(Role::item_a) || !columns.has(Role::expected) || !columns.has(Role::answer)) return;
  const bool right = read_word(columns, row, Role::answer) == read_word(columns, row, Role::expected);
  out.yes = right ? 1 : 0;
  out.no = right ? 0 : 1;
  out.ties = 0;
}

std::string joined(const Columns& columns, const Table::Row& row) {
  std::string out;
  for (const size_t column : columns.all(Role::condition)) {
    if (row.fields[column].empty()) throw columns.wrong(row, Role::condition, "every row needs one");
    out += (out.empty() ? "" : ", ") + row.fields[column];
  }
  return out;
}

void read_items(const Columns& columns, const Table::Row& row, Names& items, Answer& out) {
  const std::string& a = columns.required(row, Role::item_a);
  const std::string& b = columns.required(row, Role::item_b);
  if (a == b && (!columns.has(Role::catch_kind) || columns.field(row, Role::catch_kind).empty()))
    throw Error(columns.where(row), fmt::format("'{}' is compared with itself", printable(a, 60)),
                "such a trial is a catch trial: name its kind in the column `catch`");
  if (columns.has(Role::shown_first)) {
    const std::string& first = columns.required(row, Role::shown_first);
    if (first != a && first != b) throw columns.wrong(row, Role::shown_first, "it is the name of one of the two items");
    out.shown_first_is_a = first == a;
  }
  out.item_a = items.of(a);
  out.item_b = items.of(b);
}

double read_level(const Columns& columns, const Table::Row& row) {
  const double level = columns.number(row, Role::level);
  const double size = std::fabs(level);
  if (size > kLargestLevel || (size < kSmallestLevel && size != 0))
    throw columns.wrong(row, Role::level,
                        fmt::format("a level other than 0 has a size from {:g} to {:g}: choose another unit",
                                    kSmallestLevel, kLargestLevel));
  return level;
}

// A count; an empty field is 0.
uint64_t count_if_any(const Columns& columns, const Table::Row& row, Role role) {
  return columns.has(role) && !columns.field(row, role).empty() ? columns.count(row, role) : 0;
}

// A number; nothing where there is no column or the field is empty.
std::optional<double> number_if_any(const Columns& columns, const Table::Row& row, Role role) {
  if (!columns.has(role) || columns.field(row, role).empty()) return std::nullopt;
  return columns.number(row, role);
}

void read_calibration(const Columns& columns, const Table::Row& row, Answer& out) {
  const std::optional<double> pixels = number_if_any(columns, row, Role::pixels_per_degree);
  const std::optional<double> error = number_if_any(columns, row, Role::pixels_per_degree_se);
  const std::optional<double> ratio = number_if_any(columns, row, Role::css_px_per_clip_px);
  if (ratio && (*ratio < 1 / kLargestPixelRatio || *ratio > kLargestPixelRatio)) return;
  out.css_px_per_clip_px = ratio.value_or(1);
  if (!pixels || !error || !is_screen_calibration(*pixels, *error)) return;
  out.pixels_per_degree = pixels;
  out.pixels_per_degree_se = error;
}

void read_rest(const Columns& columns, const Table::Row& row, Answer& out) {
  if (columns.has(Role::trial)) out.trial = columns.required(row, Role::trial);
  if (columns.has(Role::observers)) out.simulated = lower(columns.field(row, Role::observers)) == "simulated";
  if (columns.has(Role::level)) out.level = read_level(columns, row);
  if (columns.has(Role::signal)) {
    const Word word = word_of(columns.required(row, Role::signal));
    if (word != Word::yes && word != Word::no) throw columns.wrong(row, Role::signal, "it is 1 or 0");
    out.signal = word == Word::yes;
  }
  if (columns.has(Role::yes_first) && !columns.field(row, Role::yes_first).empty()) {
    const Word word = word_of(columns.field(row, Role::yes_first));
    if (word != Word::yes && word != Word::no) throw columns.wrong(row, Role::yes_first, "it is 1, 0 or empty");
    out.yes_first = word == Word::yes;
  }
  read_calibration(columns, row, out);
  out.hidden = count_if_any(columns, row, Role::hidden);
  out.frames_dropped = count_if_any(columns, row, Role::frames_dropped);
  if (columns.has(Role::rt) && !columns.field(row, Role::rt).empty() && columns.field(row, Role::rt) != "null") {
    out.rt_ms = columns.number(row, Role::rt);
    if (*out.rt_ms < 0) throw columns.wrong(row, Role::rt, "a time is not below 0");
  }
}

}  // namespace

ColumnMap parse_column_map(const std::string& text, const std::string& where) {
  ColumnMap out;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find(',', at), text.size());
    const std::string piece = text.substr(at, end - at);
    const size_t equals = piece.find('=');
    const std::string role = piece.substr(0, equals);
    if (equals == std::string::npos || equals + 1 == piece.size())
      throw Error(where, fmt::format("'{}' is not ROLE=COLUMN", printable(piece, 60)),
                  "as participant=observer,level=distance,answer=seen");
    const auto& all = role_names();
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& each) { return each.first == role; });
    if (found == all.end())
      throw Error(where, fmt::format("there is no role '{}'", printable(role, 60)),
                  fmt::format("there are {}", nearest_first(role, names_of_roles(), all.size())));
    out.columns.emplace_back(found->second, piece.substr(equals + 1));
    at = end + 1;
  }
  return out;
}

ColumnMap columns_by_name(const Table& table) {
  ColumnMap out;
  for (const auto& [name, role] : role_names())
    if (std::find(table.columns.begin(), table.columns.end(), name) != table.columns.end())
      out.columns.emplace_back(role, name);
  return out;
}

void add_answers(Answers& to, const Table& table, const ColumnMap& map) {
  const Columns columns(table, map);
  Names participants(to.participants);
  Names tasks(to.tasks);
  Names conditions(to.conditions);
  Names clips(to.clips);
  Names items(to.items);
  Names stimuli(to.stimuli);
  Names studies(to.studies);
  std::map<std::tuple<uint32_t, std::string, std::string>, std::string> seen;
  for (const Answer& row : to.rows)
    if (!row.trial.empty())
      seen.emplace(std::tuple(row.participant.value_or(0), row.task ? to.tasks[*row.task] : "", row.trial),
                   fmt::format("{}:{}", to.sources[row.source], row.line));
  if (columns.has(Role::condition) && to.condition_columns.empty())
    for (const size_t column : columns.all(Role::condition)) to.condition_columns.push_back(table.columns[column]);
  to.sources.push_back(table.source);
  for (const Table::Row& row : table.rows) {
    Answer out;
    out.source = to.sources.size() - 1;
    out.line = row.line;
    if (columns.has(Role::participant)) out.participant = participants.of(columns.required(row, Role::participant));
    if (columns.has(Role::task)) out.task = tasks.of(columns.required(row, Role::task));
    if (columns.has(Role::condition)) out.condition = conditions.of(joined(columns, row));
    if (columns.has(Role::clip)) out.clip = clips.of(columns.required(row, Role::clip));
    if (columns.has(Role::stimulus)) out.stimulus = stimuli.of(columns.required(row, Role::stimulus));
    if (columns.has(Role::study)) out.study = studies.of(columns.required(row, Role::study));
    if (columns.has(Role::item_a)) read_items(columns, row, items, out);
    read_rest(columns, row, out);
    if (columns.has(Role::answer))
      read_answer(columns, row, out);
    else
      read_counts(columns, row, out);
    if (columns.has(Role::catch_kind)) read_catch(columns, row, out);
    if (!out.trial.empty()) {
      const auto [first, added] = seen.emplace(
          std::tuple(out.participant.value_or(0), out.task ? to.tasks[*out.task] : "", out.trial), columns.where(row));
      if (!added)
        throw Error(columns.where(row),
                    fmt::format("trial '{}' was answered at {} already", printable(out.trial, 60), first->second),
                    "remove one of the two rows");
    }
    to.rows.push_back(std::move(out));
  }
}

std::vector<Exclusion> exclude_by_catch(Answers& answers, double least) {
  std::map<uint32_t, Exclusion> by;
  for (const Answer& row : answers.rows) {
    if (row.catch_kind.empty() || !row.participant) continue;
    Exclusion& one = by[*row.participant];
    one.participant = answers.participants[*row.participant];
    one.right += row.yes;
    one.of += row.count();
  }
  std::vector<Exclusion> out;
  std::set<uint32_t> gone;
  for (const auto& [participant, one] : by)
    if (one.of > 0 && static_cast<double>(one.right) < least * static_cast<double>(one.of)) {
      gone.insert(participant);
      out.push_back(one);
    }
  std::erase_if(answers.rows, [&](const Answer& row) {
    return !row.catch_kind.empty() || (row.participant && gone.contains(*row.participant));
  });
  return out;
}

LeftOut leave_out(Answers& answers, const TrialRules& rules) {
  LeftOut out;
  const auto fast = [&](const Answer& row) { return row.rt_ms && *row.rt_ms < rules.shortest_rt_ms; };
  const auto dropped = [&](const Answer& row) {
    return rules.most_frames_dropped && row.frames_dropped > *rules.most_frames_dropped;
  };
  const auto out_of_sight = [&](const Answer& row) { return rules.hidden && row.hidden > 0; };
  std::erase_if(answers.rows, [&](const Answer& row) {
    const bool hidden = out_of_sight(row) && row.catch_kind.empty();
    if (fast(row))
      ++out.fast;
    else if (dropped(row))
      ++out.dropped;
    else if (hidden)
      ++out.hidden;
    return fast(row) || dropped(row) || hidden;
  });
  for (Answer& row : answers.rows) {
    if (!out_of_sight(row)) continue;
    row.no = row.count();
    row.yes = row.ties = 0;
    ++out.hidden_catch;
  }
  return out;
}

}  // namespace crowdbench::studies
