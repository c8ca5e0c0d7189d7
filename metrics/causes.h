// Error by cause: what of the squared error of a picture is owed to what, for each agent and for the whole picture.
//
// A chain of pictures leads from the reference to the test, and each differs from the one before by one cause alone:
// what the test has of it was put in the place of what the reference has. A cause's amount is what the squared error
// against the reference grows by when the cause is put in, in the order of causes(). The amounts and the residue
// therefore add up to the whole error exactly: all are whole numbers. An amount is negative where a later cause undoes
// some of an earlier one's error.
//
// Based on: nothing published is followed. Attribution by substituting one factor after the other, and its dependence
// on the order, are those of sequential decompositions of a difference (Fortin, Lemieux and Firpo, "Decomposition
// methods in economics", 2011, section 2); the order is stated, not averaged over.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/image.h"

namespace crowdbench::metrics {

// In the order in which they are substituted.
enum class Cause : uint8_t { pose, view, place, order, silhouette, surface, shading, texture, level };
inline constexpr size_t kCauses = 9;

struct CauseDoc {
  Cause cause;
  std::string_view name;   // for ever: key in JSON; [a-z]
  std::string_view title;  // for people, after "dominated by": "the stored view"
  std::string_view drawn;  // what is substituted where both sides can be drawn anew
  std::string_view read;   // what is substituted where there are two pictures only
};
std::span<const CauseDoc> causes();  // kCauses of them, by Cause
const CauseDoc& doc_of(Cause cause);

// A picture of the chain. No cause: what this step adds is the residue.
struct CauseStep {
  std::optional<Cause> cause;
  Image8 codes;
};

// Squared differences of code values, summed over R, G and B of pixels.
struct CauseRow {
  uint32_t id = 0;      // agent index + 1; 0: of no agent
  uint64_t pixels = 0;  // that are counted for it
  std::array<int64_t, kCauses> amounts{};
  int64_t residue = 0;
  int64_t total = 0;  // amounts and residue, exactly
  int64_t amount(Cause cause) const { return amounts[static_cast<size_t>(cause)]; }
  // The largest amount above 0; nothing where there is none.
  std::optional<Cause> largest() const;
};

struct CauseErrors {
  std::array<std::string, kCauses>
      reasons;                   // why a cause could not be told; empty where it could. Its amount is then 0
  CauseRow whole;                // all pixels
  std::vector<CauseRow> agents;  // by ascending id, pixels of no agent left out
  bool available(Cause cause) const { return reasons[static_cast<size_t>(cause)].empty(); }
  const CauseRow* agent(uint32_t id) const;
};
// All causes not available, for one reason.
std::array<std::string, kCauses> no_causes(const std::string& reason);

// steps: at least one; the last is the test's picture. Causes may be missing, and come at most once. owners: the agent
// that each pixel is counted for, at every step alike; 0 none. Pictures of three channels or more (further ones are
// ignored) or of one. Throws Error when sizes differ.
CauseErrors error_by_cause(const Image8& reference, std::span<const CauseStep> steps, const ImageU32& owners);

// Of each pixel the first of the buffers that names an agent there. At least one; all of one size.
ImageU32 owners_of(std::span<const ImageU32* const> ids);

// The causes in their order, with what is substituted, as Markdown.
std::string causes_markdown();

}  // namespace crowdbench::metrics
