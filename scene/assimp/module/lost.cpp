#include <algorithm>
#include <string_view>

#include "scene/assimp/module/conversion.h"

namespace crowdbench::scene::assimp_module {
namespace {

bool has_other_pictures(const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMaterials; ++m)
    for (int type = aiTextureType_DIFFUSE; type <= AI_TEXTURE_TYPE_MAX; ++type) {
      const bool read = type == aiTextureType_DIFFUSE || type == aiTextureType_BASE_COLOR ||
                        type == aiTextureType_EMISSIVE || type == aiTextureType_OPACITY;
      if (!read && scene.mMaterials[m]->GetTextureCount(static_cast<aiTextureType>(type)) > 0) return true;
    }
  return false;
}

bool has_blend_shapes(const aiScene& scene) {
  return std::any_of(scene.mMeshes, scene.mMeshes + scene.mNumMeshes,
                     [](const aiMesh* mesh) { return mesh->mNumAnimMeshes > 0; });
}

bool mentions(const Request& request, std::string_view text) {
  const uint8_t* end = request.bytes + request.size;
  return std::search(request.bytes, end, text.begin(), text.end()) != end;
}

}  // namespace

void find_lost(Conversion& c) {
  const aiScene& scene = c.scene;
  if (scene.mNumCameras > 0) c.lost.insert("cameras");
  if (scene.mNumLights > 0) c.lost.insert("lights");
  if (has_blend_shapes(scene)) c.lost.insert("blend shapes");
  if (has_other_pictures(scene)) c.lost.insert("pictures other than of base colour and emission");
  // Assimp says nothing of these; the names of objects in FBX's text and binary form, and a word of COLLADA's.
  using namespace std::string_view_literals;
  const bool fbx = c.request.format == Format::fbx;
  if (fbx && (mentions(c.request, "Constraint::"sv) || mentions(c.request, "\0\1Constraint"sv)))
    c.lost.insert("constraints");
  if (!fbx && mentions(c.request, ">BEZIER"sv)) c.lost.insert("bent curves between keys");
  // Assimp 5.2 looks for what a clip names beside the clip.
  if (!fbx && mentions(c.request, "<animation_clip"sv))
    c.warn("its clips are not told apart: what they animate plays at once, in one clip");
}

}  // namespace crowdbench::scene::assimp_module
