// Base colour, opacity, light given off, and their pictures.
//
// Differs between the formats: both say that a texture replaces the colour of what it is connected to, while glTF
// multiplies the two, so a textured material's colour is white here. Colours are taken as linear, as Blender writes
// them. A material said to be wholly transparent is drawn opaque: exporters that mean "opaque" write that too.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "scene/assimp/module/conversion.h"

namespace crowdbench::scene::assimp_module {
namespace {

class Materials {
 public:
  explicit Materials(Conversion& c) : c_(c) {}

  void run() {
    for (unsigned m = 0; m < c_.scene.mNumMaterials; ++m) {
      const aiMaterial& in = *c_.scene.mMaterials[m];
      const std::string name = in.GetName().C_Str();
      c_.label("materials", c_.glb.add("materials", convert(in, name)), "material " + shown(name));
    }
  }

 private:
  nlohmann::json convert(const aiMaterial& in, const std::string& name) {
    nlohmann::json pbr = {{"metallicFactor", 0}};
    aiColor4D colour(1, 1, 1, 1);
    if (in.Get(AI_MATKEY_BASE_COLOR, colour) != aiReturn_SUCCESS) in.Get(AI_MATKEY_COLOR_DIFFUSE, colour);
    aiString picture;
    for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
      if (in.GetTexture(type, 0, &picture) != aiReturn_SUCCESS) continue;
      colour = aiColor4D(1, 1, 1, 1);
      if (const auto texture = texture_json(in, type, picture, name)) pbr["baseColorTexture"] = *texture;
      break;
    }
    const float alpha = opacity(in, name);
    pbr["baseColorFactor"] = {colour.r, colour.g, colour.b, alpha};
    nlohmann::json out = {{"name", name}, {"pbrMetallicRoughness", pbr}};
    aiString mask;
    const bool masked = in.GetTexture(aiTextureType_OPACITY, 0, &mask) == aiReturn_SUCCESS;
    if (masked && !(mask == picture)) c_.lost.insert("opacity in pictures of its own");
    if (alpha < 1.0F || (masked && mask == picture)) out["alphaMode"] = "BLEND";
    int two_sided = 0;
    if (in.Get(AI_MATKEY_TWOSIDED, two_sided) == aiReturn_SUCCESS && two_sided != 0) out["doubleSided"] = true;
    add_emission(in, name, out);
    return out;
  }

  float opacity(const aiMaterial& in, const std::string& name) {
    float alpha = 1.0F;
    in.Get(AI_MATKEY_OPACITY, alpha);
    if (alpha > 0.0F) return std::min(alpha, 1.0F);
    c_.warn(fmt::format("material {} says that nothing of it can be seen, and is drawn opaque", shown(name)));
    return 1.0F;
  }

  void add_emission(const aiMaterial& in, const std::string& name, nlohmann::json& out) {
    aiColor3D light(0, 0, 0);
    in.Get(AI_MATKEY_COLOR_EMISSIVE, light);
    aiString picture;
    if (in.GetTexture(aiTextureType_EMISSIVE, 0, &picture) == aiReturn_SUCCESS) {
      const auto texture = texture_json(in, aiTextureType_EMISSIVE, picture, name);
      if (!texture) return;
      light = aiColor3D(1, 1, 1);
      out["emissiveTexture"] = *texture;
    }
    const float strength = std::max({light.r, light.g, light.b, 1.0F});
    if (light == aiColor3D(0, 0, 0)) return;
    out["emissiveFactor"] = {light.r / strength, light.g / strength, light.b / strength};
    if (strength > 1.0F) {
      out["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", strength}};
      c_.glb.document()["extensionsUsed"] = {"KHR_materials_emissive_strength"};
    }
  }

  std::optional<nlohmann::json> texture_json(const aiMaterial& in, aiTextureType type, const aiString& path,
                                             const std::string& material) {
    const int image = image_of(path, material);
    if (image < 0) return std::nullopt;
    std::array<int, 2> wrap = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
    in.Get(AI_MATKEY_MAPPINGMODE_U(type, 0), wrap[0]);
    in.Get(AI_MATKEY_MAPPINGMODE_V(type, 0), wrap[1]);
    int set = 0;
    in.Get(AI_MATKEY_UVWSRC(type, 0), set);
    aiUVTransform moved;
    if (in.Get(AI_MATKEY_UVTRANSFORM(type, 0), moved) == aiReturn_SUCCESS &&
        !(moved.mTranslation == aiVector2D(0, 0) && moved.mScaling == aiVector2D(1, 1) && moved.mRotation == 0))
      c_.lost.insert("moved or scaled textures");
    return nlohmann::json{{"index", texture(image, wrap)}, {"texCoord", std::clamp(set, 0, 3)}};
  }

  int texture(int image, const std::array<int, 2>& wrap) {
    const std::array<int, 3> key = {image, wrap[0], wrap[1]};
    const auto found = textures_.find(key);
    if (found != textures_.end()) return found->second;
    const auto number = [](int mode) {
      return mode == aiTextureMapMode_Clamp || mode == aiTextureMapMode_Decal ? 33071
             : mode == aiTextureMapMode_Mirror                                ? 33648
                                                                              : 10497;
    };
    const int sampler = c_.glb.add("samplers", {{"wrapS", number(wrap[0])}, {"wrapT", number(wrap[1])}});
    const int index = c_.glb.add("textures", {{"source", image}, {"sampler", sampler}});
    textures_.emplace(key, index);
    return index;
  }

  // -1: there is none that can be read, and a warning says so.
  int image_of(const aiString& path, const std::string& material) {
    const std::string key = path.C_Str();
    const auto found = images_.find(key);
    if (found != images_.end()) return found->second;
    const aiTexture* embedded = c_.scene.GetEmbeddedTexture(path.C_Str());
    const int image = embedded ? embedded_image(*embedded) : file_image(key);
    if (image >= 0)
      c_.label("images", image, "texture " + shown(key));
    else
      c_.warn(fmt::format("texture {} of material {} {}, and is drawn white", shown(key), shown(material),
                          image == kMissing ? "is not in the file's folder" : "is not a PNG, JPEG or WebP picture"));
    images_.emplace(key, image);
    return image;
  }

  // A height of 0 says that the picture is kept as the file has it.
  int embedded_image(const aiTexture& texture) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(texture.pcData);
    const size_t size = texture.mWidth;
    if (texture.mHeight != 0 || !bytes || size == 0) return kUnreadable;
    if (c_.request.judge_picture(c_.request.context, bytes, size) != Picture::readable) return kUnreadable;
    // The type is said by the bytes themselves; this member has to be there.
    return c_.glb.add("images", {{"bufferView", c_.glb.view(bytes, size)}, {"mimeType", "image/png"}});
  }

  int file_image(const std::string& path) {
    std::array<char, kUriBytes> uri{};
    switch (c_.request.find_picture(c_.request.context, path.c_str(), uri.data())) {
      case Picture::readable: break;
      case Picture::missing: return kMissing;
      case Picture::unreadable: return kUnreadable;
    }
    return c_.glb.add("images", {{"uri", uri.data()}});
  }

  static constexpr int kMissing = -1;
  static constexpr int kUnreadable = -2;
  Conversion& c_;
  std::map<std::string, int> images_;  // by path
  std::map<std::array<int, 3>, int> textures_;
};

}  // namespace

void convert_materials(Conversion& c) { Materials(c).run(); }

}  // namespace crowdbench::scene::assimp_module
