// The tree of an FBX file, text or binary, walked without being kept. Internal to the module.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace crowdbench::scene::assimp_module {

// A node's own properties. Of long lists that nobody asks for, only how many there are.
struct FbxNode {
  std::string name;
  std::vector<std::string> strings;  // as written; binary files have "body\0\1Geometry" for "Geometry::body"
  std::vector<double> numbers;
  uint64_t count = 0;     // of numbers
  int64_t declared = -1;  // "*18"; -1: says nothing
};

class FbxVisitor {
 public:
  virtual ~FbxVisitor() = default;
  // Whether numbers of nodes of that name are wanted, or how many there are alone.
  virtual bool wants(const std::string& name) const = 0;
  // path: the names of the nodes above. Each node once, its children between the two calls.
  virtual void begin(const std::vector<std::string>& path, const FbxNode& node) = 0;
  virtual void end(const std::vector<std::string>& path, const std::string& name) = 0;
};

// As far as the bytes can be followed; what is broken ends the walk without a word.
void walk_fbx(std::span<const uint8_t> bytes, FbxVisitor& visitor);

}  // namespace crowdbench::scene::assimp_module
