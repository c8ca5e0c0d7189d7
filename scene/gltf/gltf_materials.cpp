#include "scene/gltf/gltf_materials.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <span>

#include "core/error.h"
#include "scene/gltf/gltf_images.h"

namespace crowdbench::scene {
namespace {

// glTF's number (OpenGL's) of a minFilter; what a file leaves out is trilinear.
MinFilter min_filter_of(int filter) {
  switch (filter) {
    case TINYGLTF_TEXTURE_FILTER_NEAREST: return MinFilter::nearest;
    case TINYGLTF_TEXTURE_FILTER_LINEAR: return MinFilter::linear;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST: return MinFilter::nearest_mipmap_nearest;
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST: return MinFilter::linear_mipmap_nearest;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR: return MinFilter::nearest_mipmap_linear;
    default: return MinFilter::linear_mipmap_linear;
  }
}

UvSource uv_source(int tex_coord, const tinygltf::ExtensionMap& extensions) {
  UvSource uv;
  uv.set = std::max(tex_coord, 0);
  const auto found = extensions.find("KHR_texture_transform");
  if (found == extensions.end()) return uv;
  const tinygltf::Value& t = found->second;
  const auto pair = [&](const char* key) {
    return glm::dvec2(t.Get(key).Get(0).GetNumberAsDouble(), t.Get(key).Get(1).GetNumberAsDouble());
  };
  uv.offset = pair("offset");
  uv.rotation = t.Get("rotation").GetNumberAsDouble();
  uv.scale = pair("scale");
  return uv;
}

}  // namespace

GltfMaterials::GltfMaterials(GltfAsset& asset, const std::vector<bool>& used) : asset_(asset) {
  for (size_t i = 0; i < asset_.model->materials.size(); ++i) {
    const tinygltf::Material& in = asset_.model->materials[i];
    Material out;
    out.name = in.name;
    out.slot = static_cast<uint8_t>(std::min<size_t>(i, 255));
    out.double_sided = in.doubleSided;
    if (in.alphaMode == "MASK") out.alpha_cutoff = static_cast<float>(in.alphaCutoff);
    out.unlit = in.extensions.count("KHR_materials_unlit") != 0;
    const auto& pbr = in.pbrMetallicRoughness;
    for (int c = 0; c < 4 && pbr.baseColorFactor.size() == 4; ++c)
      out.base_colour[c] = static_cast<float>(pbr.baseColorFactor[index_of(c)]);
    double strength = 1.0;
    if (const auto found = in.extensions.find("KHR_materials_emissive_strength"); found != in.extensions.end())
      strength = found->second.Get("emissiveStrength").GetNumberAsDouble();
    for (int c = 0; c < 3 && in.emissiveFactor.size() == 3; ++c)
      out.emissive[c] = static_cast<float>(in.emissiveFactor[index_of(c)] * strength);
    if (used[i]) {
      if (pbr.baseColorTexture.index >= 0) out.base_colour_image = texture(pbr.baseColorTexture.index);
      if (in.emissiveTexture.index >= 0 && out.emissive != glm::vec3(0.0F))
        out.emissive_image = texture(in.emissiveTexture.index);
    }
    base_uv_.push_back(uv_source(pbr.baseColorTexture.texCoord, pbr.baseColorTexture.extensions));
    emissive_uv_.push_back(uv_source(in.emissiveTexture.texCoord, in.emissiveTexture.extensions));
    asset_.character.materials.push_back(std::move(out));
  }
}

int GltfMaterials::default_material() {
  if (default_material_ < 0) {
    default_material_ = static_cast<int>(asset_.character.materials.size());
    Material material;
    material.name = "default";
    material.slot = static_cast<uint8_t>(std::min(default_material_, 255));
    asset_.character.materials.push_back(material);
    base_uv_.emplace_back();
    emissive_uv_.emplace_back();
  }
  return default_material_;
}

int GltfMaterials::texture(int index) {
  const tinygltf::Texture& in = asset_.model->textures[index_of(index)];
  if (in.source < 0) {
    asset_.warn(fmt::format("/textures/{}: has no PNG, JPEG or WebP source and is drawn white", index));
    return -1;
  }
  int wrap_s = TINYGLTF_TEXTURE_WRAP_REPEAT;
  int wrap_t = TINYGLTF_TEXTURE_WRAP_REPEAT;
  bool nearest = false;
  MinFilter min_filter = MinFilter::linear_mipmap_linear;
  if (in.sampler >= 0) {
    const tinygltf::Sampler& sampler = asset_.model->samplers[index_of(in.sampler)];
    wrap_s = sampler.wrapS;
    wrap_t = sampler.wrapT;
    nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    min_filter = min_filter_of(sampler.minFilter);
  }
  const std::array<int, 5> key = {in.source, wrap_s, wrap_t, nearest ? 1 : 0, static_cast<int>(min_filter)};
  const auto [place, fresh] = texture_index_.emplace(key, static_cast<int>(asset_.character.images.size()));
  if (!fresh) return place->second;
  Texture out;
  out.image = decode(asset_.plan.images[index_of(in.source)]);
  out.repeat_u = wrap_s != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  out.repeat_v = wrap_t != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  out.mirrored_u = wrap_s == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT;
  out.mirrored_v = wrap_t == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT;
  out.nearest = nearest;
  out.min_filter = min_filter;
  asset_.character.images.push_back(std::move(out));
  return place->second;
}

Image8 GltfMaterials::decode(const GltfImage& image) {
  std::vector<uint8_t> fetched;
  std::span<const uint8_t> bytes = image.bytes;
  if (!image.uri.empty()) {
    fetched = asset_.source.fetch(image.uri, image.path + "/uri");
    bytes = fetched;
  }
  const std::string where = asset_.source.where() + ": " + image.path;
  const PictureHeader header = picture_header(bytes, where);
  const std::string size = fmt::format("picture is {} x {}", header.width, header.height);
  if (header.width > asset_.limits.image_side || header.height > asset_.limits.image_side)
    throw Error(where, fmt::format("{}, the limit is {} a side", size, asset_.limits.image_side),
                "use a smaller texture");
  if (header.format == PictureFormat::jpeg && header.pixels() > asset_.limits.jpeg_pixels)
    throw Error(where, fmt::format("{}, the limit for JPEG is {} pixels", size, asset_.limits.jpeg_pixels),
                "use a smaller texture or a PNG");
  if (header.pixels() * 4 > asset_.limits.image_bytes - decoded_bytes_)
    throw Error(where, fmt::format("{}, which brings all textures above {} bytes", size, asset_.limits.image_bytes),
                "use smaller textures");
  decoded_bytes_ += header.pixels() * 4;
  return decode_picture(bytes, header, where);
}

}  // namespace crowdbench::scene
