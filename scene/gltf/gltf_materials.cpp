#include "scene/gltf/gltf_materials.h"

#include <algorithm>
#include <span>

#include "core/error.h"
#include "scene/gltf/gltf_images.h"

namespace crowdbench::scene {
GltfMaterials::GltfMaterials(GltfAsset& asset, const std::vector<bool>& used) : asset_(asset) {
  for (size_t i = 0; i < asset_.plan.model.materials.size(); ++i) {
    const GltfMaterial& in = asset_.plan.model.materials[i];
    Material out;
    out.name = in.name;
    out.slot = static_cast<uint8_t>(std::min<size_t>(i, 255));
    out.double_sided = in.double_sided;
    out.alpha_cutoff = static_cast<float>(in.alpha_cutoff);
    out.unlit = in.unlit;
    out.base_colour = glm::vec4(in.base_colour);
    out.emissive = glm::vec3(in.emissive);
    if (used[i]) {
      if (in.base_colour_texture.texture >= 0) out.base_colour_image = texture(in.base_colour_texture.texture);
      if (in.emissive_texture.texture >= 0 && out.emissive != glm::vec3(0.0F))
        out.emissive_image = texture(in.emissive_texture.texture);
    }
    base_uv_.push_back(in.base_colour_texture.uv);
    emissive_uv_.push_back(in.emissive_texture.uv);
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
  const GltfModel& model = asset_.plan.model;
  const GltfTexture& in = model.textures[index_of(index)];
  if (in.image < 0) {
    asset_.warn(fmt::format("/textures/{}: has no PNG, JPEG or WebP source and is drawn white", index));
    return -1;
  }
  const GltfSampler how = in.sampler >= 0 ? model.samplers[index_of(in.sampler)] : GltfSampler();
  const std::array<int, 5> key = {in.image, static_cast<int>(how.wrap_u), static_cast<int>(how.wrap_v),
                                  how.nearest ? 1 : 0, static_cast<int>(how.min_filter)};
  const auto [place, fresh] = texture_index_.emplace(key, static_cast<int>(asset_.character.images.size()));
  if (!fresh) return place->second;
  Texture out;
  out.image = picture(in.image);
  out.repeat_u = how.wrap_u != GltfWrap::clamp;
  out.repeat_v = how.wrap_v != GltfWrap::clamp;
  out.mirrored_u = how.wrap_u == GltfWrap::mirrored;
  out.mirrored_v = how.wrap_v == GltfWrap::mirrored;
  out.nearest = how.nearest;
  out.min_filter = how.min_filter;
  asset_.character.images.push_back(std::move(out));
  return place->second;
}

Image8 GltfMaterials::picture(int image) {
  const auto [place, fresh] = decoded_.emplace(image, static_cast<int>(asset_.character.images.size()));
  const GltfImage& in = asset_.plan.images[index_of(image)];
  if (fresh) return decode(in);
  const Image8& first = asset_.character.images[index_of(place->second)].image;
  spend(first.data.size(), asset_.source.where() + ": " + in.path, first.width, first.height);
  return first;
}

void GltfMaterials::spend(size_t bytes, const std::string& where, int width, int height) {
  if (bytes > asset_.limits.image_bytes - decoded_bytes_)
    throw Error(where,
                fmt::format("picture is {} x {}, which brings all textures above {} bytes", width, height,
                            asset_.limits.image_bytes),
                "use smaller textures");
  decoded_bytes_ += bytes;
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
  spend(header.pixels() * 4, where, header.width, header.height);
  return decode_picture(bytes, header, where);
}

}  // namespace crowdbench::scene
