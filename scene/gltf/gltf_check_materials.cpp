// What a glTF document says of images, samplers, textures and materials.
#include <algorithm>
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
    json clean = json::object();
    const auto one_of = [&](const char* key, std::initializer_list<uint64_t> allowed) {
      const json* value = check.member(sampler, key);
      if (!value) return;
      const uint64_t v = check.integer(*value, path + "/" + key, 0, UINT64_MAX);
      if (std::find(allowed.begin(), allowed.end(), v) == allowed.end())
        check.fail(path + "/" + key, fmt::format("is {}, not a value of a sampler", v));
      clean[key] = v;
    };
    one_of("magFilter", {9728, 9729});
    one_of("minFilter", {9728, 9729, 9984, 9985, 9986, 9987});
    one_of("wrapS", {33071, 33648, 10497});
    one_of("wrapT", {33071, 33648, 10497});
    check.keep("samplers", std::move(clean));
  });
}

void check_textures(GltfCheck& check) {
  check.each("textures", [&](const json& texture, const std::string& path) {
    json clean = json::object();
    auto source = check.index_or_none(texture, path, "source", "images");
    if (const json* webp = check.extension(texture, path, "EXT_texture_webp"))
      if (const auto better = check.index_or_none(*webp, path + "/extensions/EXT_texture_webp", "source", "images"))
        source = better;
    if (source) {
      const GltfImage& image = check.plan.images[static_cast<size_t>(*source)];
      if (image.uri.empty() && image.bytes.empty()) check.fail(image.path, "has neither a uri nor a bufferView");
      clean["source"] = *source;
    }
    if (const auto sampler = check.index_or_none(texture, path, "sampler", "samplers")) clean["sampler"] = *sampler;
    check.keep("textures", std::move(clean));
  });
}

std::optional<json> texture_info(GltfCheck& check, const json& object, const std::string& parent, const char* key) {
  const json* info = check.member(object, key);
  if (!info) return std::nullopt;
  const std::string path = parent + "/" + key;
  check.require_object(*info, path);
  json clean = {{"index", check.required_index(*info, path, "index", "textures")},
                {"texCoord", check.integer_or(*info, path, "texCoord", 0, 0, 63)}};
  if (const json* transform = check.extension(*info, path, "KHR_texture_transform")) {
    const std::string at = path + "/extensions/KHR_texture_transform";
    json out = json::object();
    const json* offset = check.member(*transform, "offset");
    out["offset"] = offset ? check.numbers(*offset, at + "/offset", 2) : std::vector<double>{0, 0};
    const json* rotation = check.member(*transform, "rotation");
    out["rotation"] = rotation ? check.number(*rotation, at + "/rotation") : 0.0;
    const json* scale = check.member(*transform, "scale");
    out["scale"] = scale ? check.numbers(*scale, at + "/scale", 2) : std::vector<double>{1, 1};
    clean["texCoord"] = check.integer_or(*transform, at, "texCoord", clean["texCoord"].get<uint64_t>(), 0, 63);
    clean["extensions"] = {{"KHR_texture_transform", std::move(out)}};
  }
  return clean;
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
void check_alpha(GltfCheck& check, const json& material, const std::string& path, json& clean) {
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
  clean["alphaMode"] = "MASK";
  clean["alphaCutoff"] = cutoff;
}

// Of the older KHR_materials_pbrSpecularGlossiness the diffuse colour is what the base colour is today; a material that
// has both shows the newer.
json base_colour(GltfCheck& check, const json& material, const std::string& path) {
  json clean = json::object();
  const auto read = [&](const json& from, const std::string& at, const char* factor_key, const char* texture_key) {
    if (const json* factor = check.member(from, factor_key))
      clean["baseColorFactor"] = colour_factor(check, *factor, at + "/" + factor_key, 4);
    if (auto texture = texture_info(check, from, at, texture_key)) clean["baseColorTexture"] = *texture;
  };
  const json* older = check.extension(material, path, "KHR_materials_pbrSpecularGlossiness");
  if (const json* pbr = check.member(material, "pbrMetallicRoughness")) {
    const std::string at = path + "/pbrMetallicRoughness";
    check.require_object(*pbr, at);
    read(*pbr, at, "baseColorFactor", "baseColorTexture");
  } else if (older) {
    read(*older, path + "/extensions/KHR_materials_pbrSpecularGlossiness", "diffuseFactor", "diffuseTexture");
  }
  return clean;
}

}  // namespace

void check_materials(GltfCheck& check, const GltfData& data) {
  check_images(check, data);
  check_samplers(check);
  check_textures(check);
  check.each("materials", [&](const json& material, const std::string& path) {
    json clean = json::object();
    check.copy_name(material, path, clean);
    clean["pbrMetallicRoughness"] = base_colour(check, material, path);
    if (const json* factor = check.member(material, "emissiveFactor"))
      clean["emissiveFactor"] = colour_factor(check, *factor, path + "/emissiveFactor", 3);
    if (auto texture = texture_info(check, material, path, "emissiveTexture")) clean["emissiveTexture"] = *texture;
    clean["doubleSided"] = check.boolean_or(material, path, "doubleSided", false);
    check_alpha(check, material, path, clean);
    json extensions = json::object();
    if (check.extension(material, path, "KHR_materials_unlit")) extensions["KHR_materials_unlit"] = json::object();
    if (const json* strength = check.extension(material, path, "KHR_materials_emissive_strength")) {
      const std::string at = path + "/extensions/KHR_materials_emissive_strength";
      const json* value = check.member(*strength, "emissiveStrength");
      const double v = value ? check.number(*value, at + "/emissiveStrength") : 1.0;
      if (v < 0) check.fail(at + "/emissiveStrength", fmt::format("is {}, must not be negative", v));
      extensions["KHR_materials_emissive_strength"] = {{"emissiveStrength", v}};
    }
    clean["extensions"] = std::move(extensions);
    check.keep("materials", std::move(clean));
  });
}

}  // namespace crowdbench::scene
