// Which node of one skeleton plays which node of another. Internal to retarget.cpp.
#pragma once
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "scene/pose/skeleton_rest.h"

namespace crowdbench::scene {

class Counterparts {
 public:
  // animated: of the source's nodes. All three are referred to; find() adds what is told to their bones.
  Counterparts(SkeletonRest& target, SkeletonRest& source, const std::vector<bool>& animated);

  // By the rules of retarget.h. named: RetargetOptions::bones. Throws Error where nothing matches or a name is not
  // there.
  void find(const std::vector<std::string>& named);

  int of(int target_node) const;  // the source's node; -1: none
  size_t count() const;
  bool all_by_name() const;
  // The node of the target that carries the whole body.
  int hips() const;
  // What is above the hips moves with them.
  void leave_out_above(int node);
  // "4 by name, 14 as bones of a human body"
  std::string text() const;
  // Animated nodes of the source that nobody plays.
  std::vector<std::string> left_over() const;

 private:
  enum class How : uint8_t { none, told, name, bone };
  void pair(int target, int source, How how);
  void take_named(const std::string& text);
  void share_bone(int target, int source);
  void take_equal_names(bool human);
  void take_bones();
  [[noreturn]] void nothing_matches() const;

  SkeletonRest& target_;
  SkeletonRest& source_;
  const std::vector<bool>& animated_;
  std::vector<int> of_;   // by target node: the source's, -1: none
  std::vector<How> how_;  // likewise
  std::set<int> taken_;   // source nodes
};

inline constexpr size_t kNodesListed = 8;  // names in a message

}  // namespace crowdbench::scene
