#include "metrics/causes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <map>

#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

constexpr std::array<CauseDoc, kCauses> kDocs = {{
    {Cause::pose, "pose", "the stored frame", "the mesh in the pose that is shown instead of its own",
     "agents whom the pictures of --pose-ref explain better by half"},
    {Cause::view, "view", "the stored view",
     "that mesh as its stored view has it: from the view's direction, by parallel rays, laid on the plane that the "
     "view is drawn on, without limit of resolution",
     ""},
    {Cause::place, "place", "the place", "",
     "agents whom a shift, by fractions of a pixel too, and a change of size explain: outlines and colours that lie "
     "between the samples around where they came from"},
    {Cause::order, "order", "the order of agents",
     "pixels of two agents, each of which covers the pixel in both pictures when drawn alone, that show the other one",
     "pixels that show another agent, where that is so over 3 x 3 pixels at least, and in more pixels than all else "
     "that changed of the first one's outline"},
    {Cause::silhouette, "silhouette", "the silhouette", "all other pixels that show another agent, or one against none",
     "all other pixels that show another agent, or one against none"},
    {Cause::surface, "surface", "wrong surfaces",
     "pixels of the same agent whose depths differ by more than 1 % of its height",
     "pixels of the same agent whose depths differ by more than 2 cm, in a colour that the reference shows on it near "
     "by or farther off than the body may be thick; none of an agent that is drawn on a card, which has depths of its "
     "own"},
    {Cause::shading, "shading", "the shading",
     "of pixels of the same surface the cosine between normal and light, over the mesh's own colour",
     "pixels of the same surface whose channels all changed by one factor, in linear light or in code values, or by "
     "one "
     "amount of code values"},
    {Cause::texture, "texture", "the texture", "of pixels of the same surface base colour and light given off",
     "all other pixels of the same surface"},
    {Cause::level, "level", "the size class",
     "the level, tier or step that was chosen for the figure's size instead of the finest", ""},
}};

// Squared differences by owner.
using Sums = std::map<uint32_t, int64_t>;

Sums squared_by_owner(const Image8& a, const Image8& b, const ImageU32& owners) {
  require_same_size(a, b);
  const int last = std::min(a.channels, b.channels) - 1;
  Sums sums;
  uint32_t owner = 0;
  int64_t* sum = &sums[0];
  for (size_t i = 0; i < owners.pixels(); ++i) {
    const uint8_t* p = a.data.data() + i * static_cast<size_t>(a.channels);
    const uint8_t* q = b.data.data() + i * static_cast<size_t>(b.channels);
    int64_t squared = 0;
    for (int c = 0; c < 3; ++c) {
      const int d = int{p[std::min(c, last)]} - int{q[std::min(c, last)]};
      squared += d * d;
    }
    if (owners.data[i] != owner) sum = &sums[owner = owners.data[i]];
    *sum += squared;
  }
  return sums;
}

}  // namespace

std::span<const CauseDoc> causes() { return kDocs; }
const CauseDoc& doc_of(Cause cause) { return kDocs[static_cast<size_t>(cause)]; }

std::optional<Cause> CauseRow::largest() const {
  const auto most = std::max_element(amounts.begin(), amounts.end());
  if (*most <= 0) return std::nullopt;
  return static_cast<Cause>(most - amounts.begin());
}

const CauseRow* CauseErrors::agent(uint32_t id) const {
  const auto found =
      std::lower_bound(agents.begin(), agents.end(), id, [](const CauseRow& r, uint32_t i) { return r.id < i; });
  return found == agents.end() || found->id != id ? nullptr : &*found;
}

std::array<std::string, kCauses> no_causes(const std::string& reason) {
  std::array<std::string, kCauses> out;
  out.fill(reason);
  return out;
}

CauseErrors error_by_cause(const Image8& reference, std::span<const CauseStep> steps, const ImageU32& owners) {
  assert(!steps.empty());
  require_same_size(reference, owners);
  std::map<uint32_t, CauseRow> rows;
  for (const uint32_t id : owners.data) ++rows[id].pixels;
  Sums before;
  for (const CauseStep& step : steps) {
    Sums after = squared_by_owner(reference, step.codes, owners);
    for (auto& [id, row] : rows) {
      const int64_t amount = after[id] - before[id];
      if (step.cause)
        row.amounts[static_cast<size_t>(*step.cause)] = amount;
      else
        row.residue += amount;
      row.total = after[id];
    }
    before = std::move(after);
  }
  CauseErrors out;
  for (auto& [id, row] : rows) {
    row.id = id;
    out.whole.pixels += row.pixels;
    out.whole.residue += row.residue;
    out.whole.total += row.total;
    for (size_t c = 0; c < kCauses; ++c) out.whole.amounts[c] += row.amounts[c];
    if (id != 0) out.agents.push_back(row);
  }
  return out;
}

ImageU32 owners_of(std::span<const ImageU32* const> ids) {
  ImageU32 owners = *ids.front();
  for (const ImageU32* further : ids.subspan(1)) {
    require_same_size(owners, *further);
    for (size_t i = 0; i < owners.data.size(); ++i)
      if (owners.data[i] == 0) owners.data[i] = further->data[i];
  }
  return owners;
}

std::string causes_markdown() {
  std::string out =
      "\n# Error by cause\n\n"
      "`causes` of `compare --json`, of the rows of `quality --json` and of `distance --causes --json`.\n"
      "Squared differences of sRGB code values, summed over R, G and B of pixels. From the reference to the test one "
      "cause after the other is put in, in this order; a cause's `squared` is what the error against the reference "
      "grows by then. They and `residue` (what no cause explains: rounding, and what is not lit as the mesh is) add "
      "up to `total` exactly. Below 0: what it undoes of the error of a cause before. null: not available, `reasons` "
      "says why; its amount is in those after it.\n\n"
      "| cause | put in, by `quality` and `distance`, which can draw both sides anew | put in, by `compare` |\n"
      "|---|---|---|\n";
  for (const CauseDoc& doc : kDocs)
    out += fmt::format("| `{}` | {} | {} |\n", doc.name, doc.drawn.empty() ? "not available" : doc.drawn,
                       doc.read.empty() ? "not available" : doc.read);
  out +=
      "\n| key | unit | meaning |\n|---|---|---|\n"
      "| `squared` | code values squared | an object: each cause's amount, null where it is not available |\n"
      "| `residue` | code values squared | what no cause explains |\n"
      "| `total` | code values squared | their sum; over 3 x `pixels` it is a mean squared error |\n"
      "| `pixels` | | that are counted: all of the picture, or those of the agent (of the first picture that shows "
      "one there: the reference, the test, those between) |\n"
      "| `largest` | | the cause of the largest amount; null where no amount is above 0 |\n"
      "| `order` | | the causes as they are put in; the residue comes after the texture |\n"
      "| `reasons` | | an object: why a cause is not available |\n"
      "| `agents` | | the same for each agent, by `id` (agent index + 1) |\n"
      "| `displaced_px` | pixels | of `compare`: where the agent's middle moved to, right and down; a move by less "
      "than "
      "about 0.1 is not seen |\n"
      "| `told_px` | pixels | of `compare`: what differs of its outlines, where it was found to be, is as much as a "
      "shift by about this makes differ; a displacement of that size or less may not be told from an outline that is "
      "wrong by itself |\n"
      "| `recoloured` | | of `compare`: whether its mean colour, over the pixels that show it in both, changed by more "
      "than its lightness |\n"
      "| `displaced_m` | metres | of `compare` with depths: how far it moved away; null where its depths are others, "
      "but not by the same everywhere and with the size that goes with it: it shows another surface then, and no "
      "other place is known |\n"
      "| `surface_m` | metres | of `compare` with depths: how much farther the surface is that is drawn for it, at the "
      "same points, the median over its pixels; of a card its plane's |\n"
      "| `thickness_m` | metres | of `compare` with depths: from the nearest to the farthest of the body that the "
      "reference shows, 5 % of either end left out |\n"
      "| `card` | | of `compare` with depths: whether the test's depths of the agent lie in one plane and the "
      "reference's do not, as those of a card do; they do not say which surface a pixel shows |\n"
      "| `late` | | of `compare --pose-ref`: whether the agent shows that picture's pose, whatever its colours |\n"
      "| `changed_places_with` | | of `compare`: ids of the agents that now stand before it |\n"
      "| `by_height` | | of `quality` and `distance`: `from_px`, `below_px`, `units` (views, or agents), each cause's "
      "share of "
      "`total`, `dominant` (null: not distinguishable) and the 95 % `interval` of its share |\n"
      "| `told_by` | | of `quality`: `drawing` with `--causes`, which draws both sides anew; else `comparing` the two "
      "pictures and their ids |\n"
      "| `shares` | | each cause's amount over `total`; null where that is 0 |\n"
      "| `frames`, `tick` | | of `distance`: of how many frames, and of which one, where it is of one |\n"
      "| `representation` | | of `quality` and `distance`: what is judged |\n"
      "| `words` | | of `quality` and `distance`: what dominates, in words |\n";
  return out;
}

}  // namespace crowdbench::metrics
