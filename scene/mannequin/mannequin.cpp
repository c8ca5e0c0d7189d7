#include "scene/mannequin/mannequin.h"

#include <fmt/format.h>

#include "core/error.h"
#include "scene/mannequin/mannequin_body.h"
#include "scene/pose/normalise.h"

namespace crowdbench::scene {
namespace {

using Places = std::vector<mannequin::JointPlace>;

void check(const MannequinOptions& options) {
  if (options.triangles != 500 && options.triangles != 2200 && options.triangles != 5000) {
    throw Error("mannequin", fmt::format("triangles={} is not a level of detail", options.triangles),
                "use 500, 2200 or 5000");
  }
  if (options.joints != mannequin::kBaseJoints && options.joints != mannequin::kFullJoints) {
    throw Error("mannequin", fmt::format("joints={} is not a skeleton", options.joints), "use 20, or 53 with fingers");
  }
}

// The node of each joint. Parents come before children, so joints are taken once their parent has been.
std::vector<int> add_nodes(const Places& places, Skeleton& skeleton) {
  std::vector<int> node_of_joint(places.size(), -1);
  for (size_t done = 0; done < places.size();) {
    for (size_t j = 0; j < places.size(); ++j) {
      const int parent = places[j].parent;
      if (node_of_joint[j] >= 0 || (parent >= 0 && node_of_joint[static_cast<size_t>(parent)] < 0)) continue;
      Node node;
      node.name = places[j].name;
      node.translation = places[j].position;
      if (parent >= 0) {
        node.parent = node_of_joint[static_cast<size_t>(parent)];
        node.translation -= places[static_cast<size_t>(parent)].position;
      }
      node_of_joint[j] = static_cast<int>(skeleton.nodes.size());
      skeleton.nodes.push_back(std::move(node));
      ++done;
    }
  }
  return node_of_joint;
}

void add_joints(const Places& places, const std::vector<int>& node_of_joint, Skeleton& skeleton) {
  for (size_t j = 0; j < places.size(); ++j) {
    Joint joint;
    joint.name = places[j].name;
    joint.node = node_of_joint[j];
    joint.inverse_bind[3] = glm::dvec4(-places[j].position, 1.0);
    skeleton.joints.push_back(std::move(joint));
  }
  skeleton.root_node = node_of_joint[mannequin::hips];
}

void add_surfaces(Character& out) {
  constexpr const char* kSlotNames[] = {"skin", "hair", "shirt", "trousers", "shoes"};
  for (int slot = 0; slot < mannequin::kSlotCount; ++slot) {
    Material material;
    material.name = kSlotNames[slot];
    material.base_colour_image = 0;
    material.slot = static_cast<uint8_t>(slot);
    out.materials.push_back(std::move(material));
  }
  Texture texture;
  static const Image8 painted = mannequin::make_texture();  // the same for every option: painted once in a process
  texture.image = painted;
  texture.repeat_u = false;
  texture.repeat_v = false;
  out.images.push_back(std::move(texture));
}

}  // namespace

Character make_mannequin(const MannequinOptions& options) {
  check(options);
  Character out;
  out.name = "mannequin";
  out.source = fmt::format("mannequin:triangles={},joints={}", options.triangles, options.joints);
  const Places places = mannequin::joint_places(options.joints);
  const std::vector<int> node_of_joint = add_nodes(places, out.skeleton);
  add_joints(places, node_of_joint, out.skeleton);
  Node body;
  body.name = "body";
  const int body_node = static_cast<int>(out.skeleton.nodes.size());
  out.skeleton.nodes.push_back(std::move(body));  // the mesh's node comes last

  out.mesh = mannequin::make_mesh(options.triangles, options.joints);
  for (Primitive& primitive : out.mesh.primitives) {
    primitive.node = body_node;
    primitive.gltf_node = body_node;
  }
  add_surfaces(out);
  out.clips = mannequin::make_clips(options.joints, node_of_joint);
  out.file_max_influences = kInfluences;
  normalise(out, options.normalise);
  return out;
}

}  // namespace crowdbench::scene
