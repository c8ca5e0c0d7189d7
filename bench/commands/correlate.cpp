#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <set>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/score_bounds.h"
#include "bench/commands/score_commands.h"
#include "bench/commands/score_json.h"
#include "bench/experiments/score_agreement.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/png.h"
#include "metrics/panel.h"
#include "reports/exports/markdown_cell.h"
#include "store/store.h"

namespace crowdbench::bench {
namespace {

struct CorrelateOptions {
  std::string file;
  std::string scores = "all";
  std::string markdown, pictures;
  uint64_t worst = 6;
  bool json = false;
};

constexpr uint64_t kSeed = 1;  // of the intervals

using RankMember = std::optional<RankCorrelation> RankAgreement::*;

std::string interval_text(const std::optional<RankCorrelation>& of) {
  if (!of) return "-";
  return fmt::format("{:+.2f} ({:+.2f} to {:+.2f})", of->value, of->interval.low, of->interval.high);
}

// "flat:views=12, mannequin, 60 px, azimuth 45, elevation 0, walk at 0.25 s"
std::string row_text(const ComparisonRow& row) {
  return fmt::format("{}, {}, {:g} px, azimuth {:g}, elevation {:g}, {} at {:.3g} s", row.representation, row.character,
                     row.height_px.value_or(0), row.azimuth_deg.value_or(0), row.elevation_deg.value_or(0),
                     row.clip.empty() ? "a clip without a name" : row.clip, row.time.value_or(0));
}

std::string value_of(const ScoreAgreements& all, size_t score, size_t row) {
  return metrics::value_text(*all.scores[score], all.values[score][row]);
}

std::string summary_of(const ScoreAgreements& all) {
  std::set<std::string> characters;
  std::set<std::string> representations;
  std::set<double> heights;
  std::set<std::string> displays;
  for (const ComparisonRow* row : all.rows) {
    characters.insert(row->character);
    representations.insert(row->representation);
    heights.insert(row->height_px.value_or(0));
    if (row->display) displays.insert(*row->display + (row->display_given.value_or(false) ? "" : ", by default"));
  }
  return fmt::format(
      "{} views. Representations: {}; characters: {}; heights: {} px; display: {}. Intervals: 95 %, whole groups of "
      "one character by one representation ({} of them) drawn anew {} times.",
      all.rows.size(), fmt::join(representations, ", "), fmt::join(characters, ", "), fmt::join(heights, ", "),
      fmt::join(displays, "; "), all.groups, kRankResamples);
}

// ---- pictures

const PictureRow* picture_of(const StoreContents& contents, int64_t comparison, const std::string& role) {
  for (const PictureRow& row : contents.pictures)
    if (row.comparison == comparison && row.role == role) return &row;
  return nullptr;
}

Image8 enlarged(const Image8& image, int rows) {
  const int zoom = std::max(1, rows / std::max(1, image.height));
  Image8 out(image.width * zoom, image.height * zoom, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) std::copy_n(image.at(x / zoom, y / zoom), 3, out.at(x, y));
  return out;
}

// Pictures next to each other from the left, standing on one line, on one grey.
Image8 in_a_row(const std::vector<Image8>& pictures) {
  constexpr int kGap = 12;
  int width = -kGap;
  int height = 1;
  for (const Image8& p : pictures) {
    width += p.width + kGap;
    height = std::max(height, p.height);
  }
  Image8 out(std::max(1, width), height, 3);
  std::fill(out.data.begin(), out.data.end(), uint8_t{64});
  int left = 0;
  for (const Image8& p : pictures) {
    const int top = height - p.height;
    for (int y = 0; y < p.height; ++y) std::copy_n(p.at(0, y), 3 * static_cast<size_t>(p.width), out.at(left, top + y));
    left += p.width + kGap;
  }
  return out;
}

// "ssim 0.9312, flip 0.1203"
std::string values_text(const ScoreAgreements& all, const ScorePair& pair, size_t row) {
  return fmt::format("{} {}, {} {}", all.scores[pair.a]->name, value_of(all, pair.a, row), all.scores[pair.b]->name,
                     value_of(all, pair.b, row));
}

// Reference and test of the view that the first score prefers and then of the other's, each said in words: who prefers
// it, what both scores are, which picture is which. Nothing where the file has no pictures of them.
std::optional<Image8> draw(const StoreContents& contents, const ScoreAgreements& all, const ScorePair& pair) {
  constexpr int kRows = 240;
  constexpr int kPanel = 200;  // pixels that names may take before they are broken
  std::vector<Image8> views;
  for (const auto& [score, row] : {std::pair(pair.a, pair.worst->first), std::pair(pair.b, pair.worst->second)}) {
    const ComparisonRow& of = *all.rows[row];
    std::vector<Image8> sides;
    for (const auto& [role, name] : {std::pair("reference", &of.reference), std::pair("test", &of.representation)}) {
      const PictureRow* picture = picture_of(contents, of.id, role);
      if (picture == nullptr) return std::nullopt;
      const std::array<std::string, 2> words = {std::string(role) + ":", *name};
      sides.push_back(metrics::with_words_above(enlarged(decode_png(picture->png, role), kRows), words, kPanel));
    }
    const std::array<std::string, 3> words = {fmt::format("{} prefers this view", all.scores[score]->name),
                                              values_text(all, pair, row), row_text(of)};
    const Image8 both = in_a_row(sides);
    views.push_back(metrics::with_words_above(both, words, std::max(both.width, kPanel)));
  }
  return in_a_row(views);
}

// ---- output

Json pair_json(const ScoreAgreements& all, const ScorePair& pair) {
  Json out = {{"a", all.scores[pair.a]->name},
              {"b", all.scores[pair.b]->name},
              {"views", pair.ranks.pairs},
              {"groups", pair.ranks.groups}};
  for (const auto& [name, of] :
       {std::pair("spearman", &pair.ranks.spearman), std::pair("kendall_tau_b", &pair.ranks.kendall)})
    out[name] =
        *of ? Json{{"value", (*of)->value}, {"low", (*of)->interval.low}, {"high", (*of)->interval.high}} : Json();
  if (!pair.worst) return out;
  const auto view = [&](size_t row) {
    return Json{{"comparison", all.rows[row]->id},
                {"view", row_text(*all.rows[row])},
                {"a", json_number(all.values[pair.a][row])},
                {"b", json_number(all.values[pair.b][row])}};
  };
  out["worst"] = {{"better_by_a", view(pair.worst->first)},
                  {"better_by_b", view(pair.worst->second)},
                  {"gap_a", pair.worst->gap_a},
                  {"gap_b", pair.worst->gap_b}};
  return out;
}

Json to_json(const ScoreAgreements& all) {
  Json out = {{"views", all.rows.size()}, {"groups", all.groups}, {"resamples", kRankResamples}};
  out["scores"] = out["pairs"] = Json::array();
  for (const metrics::Score* score : all.scores) out["scores"].push_back(score->name);
  for (const ScorePair& pair : all.pairs) out["pairs"].push_back(pair_json(all, pair));
  return out;
}

std::string cell(const ScoreAgreements& all, size_t row, size_t column, RankMember member) {
  if (row == column) return "";
  const auto& of = pair_of(all, row, column).ranks.*member;
  return of ? fmt::format("{:+.2f}", of->value) : "-";
}

void print_text(const ScoreAgreements& all, const CorrelateOptions& options) {
  fmt::print("{}\n\nabove the diagonal Spearman's rho, below it Kendall's tau-b; +1: one order of how good\n{:<24}",
             summary_of(all), "");
  for (const metrics::Score* score : all.scores) fmt::print(" {:>9}", score->column);
  fmt::print("\n");
  for (size_t r = 0; r < all.scores.size(); ++r) {
    fmt::print("{:<24}", all.scores[r]->name);
    for (size_t c = 0; c < all.scores.size(); ++c)
      fmt::print(" {:>9}", cell(all, r, c, c > r ? &RankAgreement::spearman : &RankAgreement::kendall));
    fmt::print("\n");
  }
  fmt::print("\nwhere two scores disagree most about views of one height\n");
  for (const ScorePair* pair : worst_pairs(all, options.worst)) {
    const Disagreement& of = *pair->worst;
    fmt::print("{} and {}: rho {}\n", all.scores[pair->a]->name, all.scores[pair->b]->name,
               interval_text(pair->ranks.spearman));
    for (const auto& [who, row] : {std::pair(pair->a, of.first), std::pair(pair->b, of.second)})
      fmt::print("  {} prefers {} {} of {}\n", all.scores[who]->name, value_of(all, pair->a, row),
                 value_of(all, pair->b, row), row_text(*all.rows[row]));
  }
}

std::string table_markdown(const ScoreAgreements& all, RankMember member) {
  std::string out = "| |";
  std::string rule = "|---|";
  for (const metrics::Score* score : all.scores) {
    out += fmt::format(" `{}` |", score->name);
    rule += "--:|";
  }
  out += "\n" + rule + "\n";
  for (size_t r = 0; r < all.scores.size(); ++r) {
    out += fmt::format("| `{}` |", all.scores[r]->name);
    for (size_t c = 0; c < all.scores.size(); ++c) out += fmt::format(" {} |", cell(all, r, c, member));
    out += "\n";
  }
  return out;
}

// Pairs by how little they agree.
std::string intervals_markdown(const ScoreAgreements& all) {
  std::vector<const ScorePair*> pairs;
  for (const ScorePair& pair : all.pairs)
    if (pair.ranks.spearman) pairs.push_back(&pair);
  std::stable_sort(pairs.begin(), pairs.end(), [](const ScorePair* x, const ScorePair* y) {
    return x->ranks.spearman->value < y->ranks.spearman->value;
  });
  std::string out = "| scores | views | Spearman's rho (95 %) | Kendall's tau-b (95 %) |\n|---|--:|--:|--:|\n";
  for (const ScorePair* pair : pairs)
    out += fmt::format("| `{}`, `{}` | {} | {} | {} |\n", all.scores[pair->a]->name, all.scores[pair->b]->name,
                       pair->ranks.pairs, interval_text(pair->ranks.spearman), interval_text(pair->ranks.kendall));
  return out;
}

// folder: of the Markdown file, which pictures are named from.
std::string worst_markdown(const ScoreAgreements& all, const CorrelateOptions& options,
                           const std::vector<std::string>& files) {
  const std::filesystem::path folder = std::filesystem::path(options.markdown).parent_path();
  std::string out;
  const std::vector<const ScorePair*> pairs = worst_pairs(all, options.worst);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const ScorePair& pair = *pairs[i];
    const std::string a(all.scores[pair.a]->name);
    const std::string b(all.scores[pair.b]->name);
    out += fmt::format("\n### `{}` against `{}`\n\n| | view | `{}` | `{}` |\n|---|---|--:|--:|\n", a, b, a, b);
    for (const auto& [who, row] : {std::pair(a, pair.worst->first), std::pair(b, pair.worst->second)})
      out += fmt::format("| better by `{}` | {} | {} | {} |\n", who, reports::markdown_cell(row_text(*all.rows[row])),
                         value_of(all, pair.a, row), value_of(all, pair.b, row));
    if (i < files.size() && !files[i].empty())
      out += fmt::format("\n![mesh and representation of either view]({})\n",
                         std::filesystem::relative(files[i], folder.empty() ? "." : folder).generic_string());
  }
  return out;
}

std::string to_markdown(const ScoreAgreements& all, const CorrelateOptions& options,
                        const std::vector<std::string>& files) {
  return fmt::format(
      "# How far the scores agree\n\nMade by `crowdbench correlate`. {}\n\nEvery score ranks the views from worst to "
      "best; +1 is one order for both, 0 none in common, -1 the opposite. Which end of a score is good is taken into "
      "account. Equal values share the mean of their ranks (Spearman's rho) or are left out on both sides (Kendall's "
      "tau-b). `crowdbench schema --scores` says what each score is.\n\n## Spearman's rho\n\n{}\n## Kendall's "
      "tau-b\n\n{}\n## Where two scores disagree most\n\nTwo views of figures of one height of which either score "
      "holds another for the better, as far apart among all views of that height as it comes. Each picture shows "
      "reference and test of the view that the first score prefers, then of the one that the second prefers, with both "
      "scores.\n{}\n## "
      "Every pair, from the least agreement\n\n{}",
      summary_of(all), table_markdown(all, &RankAgreement::spearman), table_markdown(all, &RankAgreement::kendall),
      worst_markdown(all, options, files), intervals_markdown(all));
}

// "" where the file has no pictures of the pair.
std::vector<std::string> write_pictures(const StoreContents& contents, const ScoreAgreements& all,
                                        const CorrelateOptions& options) {
  const std::filesystem::path folder = options.pictures;
  make_folder(folder);
  std::vector<std::string> files;
  for (const ScorePair* pair : worst_pairs(all, options.worst)) {
    std::string& file = files.emplace_back();
    const std::optional<Image8> image = draw(contents, all, *pair);
    if (!image) continue;
    file = (folder / fmt::format("{}_{}.png", all.scores[pair->a]->name, all.scores[pair->b]->name)).string();
    write_png(file, *image);
  }
  return files;
}

int run_correlate(const CorrelateOptions& options, metrics::ScoreTable table) {
  const std::vector<const metrics::Score*> chosen = options.scores == "all"
                                                        ? std::vector(table.begin(), table.end())
                                                        : chosen_scores(options.scores, "--scores", table);
  const StoreContents contents = read_store(options.file, false, !options.pictures.empty());
  const ScoreAgreements all = agreements_of(contents, chosen, kSeed);
  if (all.scores.size() < 2)
    throw Error(options.file, "holds no two scores of single agents to correlate",
                "write some with `crowdbench quality --db`");
  std::vector<std::string> files;
  if (!options.pictures.empty()) files = write_pictures(contents, all, options);
  if (!options.markdown.empty()) write_file(options.markdown, std::string_view(to_markdown(all, options, files)));
  if (options.json)
    fmt::print("{}\n", to_json(all).dump(2));
  else
    print_text(all, options);
  return 0;
}

}  // namespace

void add_correlate(Command& app, Run& run) { add_correlate(app, run, metrics::scores()); }

void add_correlate(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command =
      app.add_subcommand("correlate", "How far scores agree about the same views, and where they do not");
  command->footer(
      "Reads what `quality --db` or `demo` wrote. Spearman's rho and Kendall's tau-b of every two scores, with "
      "intervals "
      "that\ndraw whole groups anew (a character by a representation), and the two views of one height about whose "
      "order "
      "two\nscores disagree most.\n\nExamples:\n"
      "  crowdbench correlate results.sqlite\n"
      "  crowdbench correlate results.sqlite --scores ssim,flip,cvvdp --markdown scores.md --pictures pictures --json");
  auto options = std::make_shared<CorrelateOptions>();
  command->add_option("FILE", options->file, "result file")->required()->type_name("FILE.sqlite");
  command->add_option("--scores", options->scores, "only these, name,name,...; all: every one that the file has")
      ->type_name("LIST")
      ->capture_default_str();
  command->add_option("--worst", options->worst, "pairs of scores whose worst disagreement is shown")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(0, 1000);
  command->add_option("--markdown", options->markdown, "the tables, and the pictures of --pictures, as a page")
      ->type_name("FILE.md")
      ->output_file();
  command
      ->add_option("--pictures", options->pictures,
                   "a folder for the pictures of the disagreements; made where "
                   "missing")
      ->type_name("DIR")
      ->output_folder();
  add_json_option(*command, options->json);
  command->callback([options, table, &run] { run = [options, table] { return run_correlate(*options, table); }; });
}

}  // namespace crowdbench::bench
