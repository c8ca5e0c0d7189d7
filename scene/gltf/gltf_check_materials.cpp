// What a glTF document says of images, samplers, textures and materials.
#include <algorithm>
#include <array>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/error.h"
#include "scene/gltf/gltf_check.h"
#include "scene/gltf/gltf_data.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;

void check_images(GltfCheck& check, const GltfData& data) {
  check.each("images", [&](const json& image, const std::string& path) {
    GltfImage out;
    out.path = path;
    const std::string* uri = check.text_or_none(image, path, "uri");
    const auto view = check.index_or_none(image, path, "bufferView", "bufferViews");
    if (uri && view) check.fail(path, "has both a uri and a bufferView");
    if (uri) {
      check.source.check_uri(*uri, path + "/uri");
      out.uri = *uri;
    } else if (view) {
      out.bytes = data.view_bytes(*view);
    }
    check.plan.images.push_back(std::move(out));
  });
}

void check_samplers(GltfCheck& check) {
  check.each("samplers", [&](const json& sampler, const std::string& path) {
    // Of the numbers that OpenGL has for these, the place of the one given, if any.
    const auto one_of = [&](const char* key, std::initializer_list<uint64_t> allowed) -> std::optional<size_t> {
      const json* value = check.member(sampler, key);
      if (!value) return std::nullopt;
      const uint64_t v = check.integer(*value, path + "/" + key, 0, UINT64_MAX);
      const auto found = std::find(allowed.begin(), allowed.end(), v);
      if (found == allowed.end()) check.fail(path + "/" + key, fmt::format("is {}, not a value of a sampler", v));
      return static_cast<size_t>(found - allowed.begin());
    };
    GltfSampler out;
    out.nearest = one_of("magFilter", {9729, 9728}) == 1;
    static constexpr std::array<MinFilter, 6> kFilters = {MinFilter::nearest,
                                                          MinFilter::linear,
                                                          MinFilter::nearest_mipmap_nearest,
                                                          MinFilter::linear_mipmap_nearest,
                                                          MinFilter::nearest_mipmap_linear,
                                                          MinFilter::linear_mipmap_linear};
    out.min_filter = kFilters[one_of("minFilter", {9728, 9729, 9984, 9985, 9986, 9987}).value_or(5)];
    static constexpr std::array<GltfWrap, 3> kWraps = {GltfWrap::repeat, GltfWrap::mirrored, GltfWrap::clamp};
    out.wrap_u = kWraps[one_of("wrapS", {10497, 33648, 33071}).value_or(0)];
    out.wrap_v = kWraps[one_of("wrapT", {10497, 33648, 33071}).value_or(0)];
    check.plan.model.samplers.push_back(out);
  });
}

void check_textures(GltfCheck& check) {
  check.each("textures", [&](const json& texture, const std::string& path) {
    GltfTexture out;
    auto source = check.index_or_none(texture, path, "source", "images");
    if (const json* webp = check.extension(texture, path, "EXT_texture_webp"))
      if (const auto better = check.index_or_none(*webp, path + "/extensions/EXT_texture_webp", "source", "images"))
        source = better;
    if (source) {
      const GltfImage& image = check.plan.images[static_cast<size_t>(*source)];
      if (image.uri.empty() && image.bytes.empty()) check.fail(image.path, "has neither a uri nor a bufferView");
      out.image = *source;
    }
    if (const auto sampler = check.index_or_none(texture, path, "sampler", "samplers")) out.sampler = *sampler;
    check.plan.model.textures.push_back(out);
  });
}

GltfTextureUse texture_use(GltfCheck& check, const json& object, const std::string& parent, const char* key) {
  GltfTextureUse use;
  const json* info = check.member(object, key);
  if (!info) return use;
  const std::string path = parent + "/" + key;
  check.require_object(*info, path);
  use.texture = check.required_index(*info, path, "index", "textures");
  use.uv.set = static_cast<int>(check.integer_or(*info, path, "texCoord", 0, 0, 63));
  if (const json* transform = check.extension(*info, path, "KHR_texture_transform")) {
    const std::string at = path + "/extensions/KHR_texture_transform";
    const auto pair = [&](const char* member, glm::dvec2& out) {
      const json* value = check.member(*transform, member);
      if (!value) return;
      const std::vector<double> two = check.numbers(*value, at + "/" + member, 2);
      out = {two[0], two[1]};
    };
    pair("offset", use.uv.offset);
    if (const json* rotation = check.member(*transform, "rotation"))
      use.uv.rotation = check.number(*rotation, at + "/rotation");
    pair("scale", use.uv.scale);
    use.uv.set =
        static_cast<int>(check.integer_or(*transform, at, "texCoord", static_cast<uint64_t>(use.uv.set), 0, 63));
  }
  return use;
}

std::vector<double> colour_factor(GltfCheck& check, const json& value, const std::string& path, size_t count) {
  std::vector<double> factor = check.numbers(value, path, count);
  for (double& f : factor) {
    if (f < 0 || f > 1) check.warn(fmt::format("{}: {} is clamped to 0..1", path, f));
    f = std::clamp(f, 0.0, 1.0);
  }
  return factor;
}

// BLEND becomes a mask: figures that are drawn in any order, and stored as surfaces, cannot be blended.
void check_alpha(GltfCheck& check, const json& material, const std::string& path, GltfMaterial& out) {
  const std::string* mode = check.text_or_none(material, path, "alphaMode");
  if (mode && *mode != "OPAQUE" && *mode != "MASK" && *mode != "BLEND")
    check.fail(path + "/alphaMode", fmt::format("is {}, not OPAQUE, MASK or BLEND", printable(*mode, 20)));
  const json* given = check.member(material, "alphaCutoff");
  double cutoff = given ? check.number(*given, path + "/alphaCutoff") : 0.5;
  if (cutoff < 0) check.fail(path + "/alphaCutoff", fmt::format("is {}, must not be negative", cutoff));
  if (!mode || *mode == "OPAQUE") return;
  if (*mode == "BLEND") {
    check.warn_once(path, "alphaMode BLEND is drawn as MASK at 0.5");
    cutoff = 0.5;
  }
  out.alpha_cutoff = cutoff;
}

// Of the older KHR_materials_pbrSpecularGlossiness the diffuse colour is what the base colour is today; a material that
// has both shows the newer.
void check_base_colour(GltfCheck& check, const json& material, const std::string& path, GltfMaterial& out) {
  const auto read = [&](const json& from, const std::string& at, const char* factor_key, const char* texture_key) {
    if (const json* factor = check.member(from, factor_key)) {
      const std::vector<double> four = colour_factor(check, *factor, at + "/" + factor_key, 4);
      out.base_colour = {four[0], four[1], four[2], four[3]};
    }
    out.base_colour_texture = texture_use(check, from, at, texture_key);
  };
  const json* older = check.extension(material, path, "KHR_materials_pbrSpecularGlossiness");
  if (const json* pbr = check.member(material, "pbrMetallicRoughness")) {
    const std::string at = path + "/pbrMetallicRoughness";
    check.require_object(*pbr, at);
    read(*pbr, at, "baseColorFactor", "baseColorTexture");
  } else if (older) {
    read(*older, path + "/extensions/KHR_materials_pbrSpecularGlossiness", "diffuseFactor", "diffuseTexture");
  }
}

}  // namespace

void check_materials(GltfCheck& check, const GltfData& data) {
  check_images(check, data);
  check_samplers(check);
  check_textures(check);
  check.each("materials", [&](const json& material, const std::string& path) {
    GltfMaterial out;
    out.name = check.name_of(material, path);
    check_base_colour(check, material, path, out);
    if (const json* factor = check.member(material, "emissiveFactor")) {
      const std::vector<double> three = colour_factor(check, *factor, path + "/emissiveFactor", 3);
      out.emissive = {three[0], three[1], three[2]};
    }
    out.emissive_texture = texture_use(check, material, path, "emissiveTexture");
    out.double_sided = check.boolean_or(material, path, "doubleSided", false);
    check_alpha(check, material, path, out);
    out.unlit = check.extension(material, path, "KHR_materials_unlit") != nullptr;
    if (const json* strength = check.extension(material, path, "KHR_materials_emissive_strength")) {
      const std::string at = path + "/extensions/KHR_materials_emissive_strength";
      const json* value = check.member(*strength, "emissiveStrength");
      const double v = value ? check.number(*value, at + "/emissiveStrength") : 1.0;
      if (v < 0) check.fail(at + "/emissiveStrength", fmt::format("is {}, must not be negative", v));
      out.emissive *= v;
    }
    check.plan.model.materials.push_back(std::move(out));
  });
}

}  // namespace crowdbench::scene
