#include <assimp/scene.h>

#include <cmath>

#include "scene/assimp/module/conversion.h"

namespace crowdbench::scene::assimp_module {
namespace {

void bound(uint64_t have, uint64_t limit, const char* what) {
  if (have > limit) throw Refusal{fmt::format("has {} {}, more than the limit of {}", have, what, limit)};
}

void require(bool holds, const std::string& what) {
  if (!holds) throw Refusal{what};
}

void check_mesh(const aiMesh& mesh, const aiScene& scene) {
  const std::string name = fmt::format("mesh {}", shown(mesh.mName.C_Str()));
  require(mesh.mNumVertices == 0 || mesh.mVertices, name + " has no positions");
  require(mesh.mNumFaces == 0 || mesh.mFaces, name + " has no faces");
  require(mesh.mNumBones == 0 || mesh.mBones, name + " has no bones");
  require(mesh.mMaterialIndex < scene.mNumMaterials, name + " names a material that is not there");
  for (unsigned f = 0; f < mesh.mNumFaces; ++f)
    for (unsigned i = 0; i < mesh.mFaces[f].mNumIndices; ++i)
      require(mesh.mFaces[f].mIndices[i] < mesh.mNumVertices, name + " names a vertex that is not there");
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    require(mesh.mBones[b] && (mesh.mBones[b]->mNumWeights == 0 || mesh.mBones[b]->mWeights), name + " lacks a bone");
    for (unsigned w = 0; w < mesh.mBones[b]->mNumWeights; ++w)
      require(mesh.mBones[b]->mWeights[w].mVertexId < mesh.mNumVertices,
              name + " gives a weight to a vertex that is not there");
  }
}

// Nodes of the whole tree and, over all of them, the triangles of their meshes.
void check_tree(const aiScene& scene, const Limits& limits) {
  std::vector<const aiNode*> stack = {scene.mRootNode};
  uint64_t nodes = 0;
  uint64_t triangles = 0;
  while (!stack.empty()) {
    const aiNode* node = stack.back();
    stack.pop_back();
    require(node, "lacks a node");
    bound(++nodes, limits.nodes, "nodes");
    for (unsigned e = 0; e < 16; ++e)
      require(std::isfinite(node->mTransformation[e / 4][e % 4]),
              fmt::format("node {} has a transform that is not finite", shown(node->mName.C_Str())));
    for (unsigned m = 0; m < node->mNumMeshes; ++m) {
      require(node->mMeshes[m] < scene.mNumMeshes, "a node names a mesh that is not there");
      triangles += scene.mMeshes[node->mMeshes[m]]->mNumFaces;
      bound(triangles, limits.triangles, "triangles");
    }
    stack.insert(stack.end(), node->mChildren, node->mChildren + node->mNumChildren);
  }
  bound(scene.mNumAnimations * nodes, limits.clip_nodes, "clips times nodes");
}

void check_animations(const aiScene& scene, const Limits& limits) {
  bound(scene.mNumAnimations, limits.clips, "clips");
  uint64_t keys = 0;
  uint64_t channels = 0;
  for (unsigned a = 0; a < scene.mNumAnimations; ++a) {
    const aiAnimation& animation = *scene.mAnimations[a];
    channels += animation.mNumChannels;
    bound(channels, kMostChannels, "animated nodes over all clips");
    for (unsigned i = 0; i < animation.mNumChannels; ++i) {
      const aiNodeAnim& channel = *animation.mChannels[i];
      keys += uint64_t{4} * channel.mNumPositionKeys + uint64_t{5} * channel.mNumRotationKeys +
              uint64_t{4} * channel.mNumScalingKeys;
      bound(keys, limits.keys, "animation numbers");
    }
  }
}

}  // namespace

void check_scene(const aiScene& scene, const Limits& limits) {
  require(scene.mRootNode, "has no nodes");
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) check_mesh(*scene.mMeshes[m], scene);
  check_tree(scene, limits);
  check_animations(scene, limits);
}

}  // namespace crowdbench::scene::assimp_module
