// An Assimp scene on its way to a glTF document, which the steps of the conversion share. Internal to the module.
#pragma once
#include <assimp/scene.h>
#include <fmt/format.h>

#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "scene/assimp/module/assimp_api.h"
#include "scene/assimp/module/glb.h"

namespace crowdbench::scene::assimp_module {

// Of a conversion: clips times the nodes that each moves. Each takes a few hundred bytes of JSON.
inline constexpr uint64_t kMostChannels = 50000;

// What ends the conversion: one line.
struct Refusal {
  std::string text;
};

// A name of the file, for a message: short, and without control characters.
std::string shown(const std::string& name);

class Conversion {
 public:
  Conversion(const aiScene& from, const Request& of) : scene(from), request(of) {}

  void warn(const std::string& text) const { request.write(request.context, Item::warning, text.data(), text.size()); }
  // What "/list/index" is to the user.
  void label(const char* list, int index, const std::string& text) const {
    const std::string line = fmt::format("/{}/{}\t{}", list, index, text);
    request.write(request.context, Item::label, line.data(), line.size());
  }
  // The node that a bone or an animation means by that name; -1: none.
  int node_named(const aiString& name) const {
    const auto found = node_of_name.find(name.C_Str());
    return found == node_of_name.end() ? -1 : found->second;
  }

  const aiScene& scene;
  const Request& request;
  Glb glb;
  std::vector<const aiNode*> nodes;  // parents before children; the document's nodes begin with these
  std::unordered_map<std::string, int> node_of_name;
  std::set<std::string> lost;  // what the file has and the document has not
};

// Counts against the limits, and every index and pointer of the scene that the steps use: throws Refusal.
void check_scene(const aiScene& scene, const Limits& limits);

// The steps, in this order. They throw Refusal.
void convert_nodes(Conversion& c);
void convert_materials(Conversion& c);
void convert_meshes(Conversion& c);
void convert_animations(Conversion& c);
// Adds to `lost` what nothing above reads.
void find_lost(Conversion& c);

}  // namespace crowdbench::scene::assimp_module
