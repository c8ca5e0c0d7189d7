// The cases of the ColorVideoVDP ground truth: what each key of its expected.json compares.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/files.h"
#include "core/image_io.h"
#include "metrics/cvvdp/cvvdp.h"
#include "metrics/difference.h"
#include "metrics/display.h"
#include "test_paths.h"

namespace crowdbench::metrics {

struct CvvdpCase {
  std::vector<AnyImage> reference, test;
  Display display;
  CvvdpOptions options;
};

// A picture of the ground truth, in the project's own folder or in the shared one; nothing where neither has it.
inline std::optional<AnyImage> ground_truth_picture(const std::string& name) {
  namespace fs = std::filesystem;
  for (const fs::path& root : {fs::path(CROWDBENCH_TEST_DATA), fs::path(CROWDBENCH_SHARED_DIR)})
    if (const fs::path file = root / "ground-truth" / name; fs::exists(file)) return read_image(file);
  return std::nullopt;
}

inline nlohmann::json cvvdp_json(const std::string& name) {
  return nlohmann::json::parse(read_text(std::filesystem::path(CROWDBENCH_TEST_DATA) / "ground-truth/cvvdp" / name));
}

class CvvdpCases {
 public:
  CvvdpCases() : expected_(cvvdp_json("expected.json")) {}

  const nlohmann::json& all() const { return expected_["cases"]; }

  Display display(const std::string& name) const {
    const nlohmann::json& custom = expected_["custom_displays"];
    if (!custom.contains(name)) return find_display(name, name);
    return parse_displays(custom[name].dump(), "expected.json", name).at(0);
  }

  // Nothing where a picture is not here.
  std::optional<CvvdpCase> load(const std::string& key) const {
    std::vector<std::string> words;
    for (size_t at = 0; at <= key.size();) {
      const size_t end = std::min(key.find('@', at), key.size());
      words.push_back(key.substr(at, end - at));
      at = end + 1;
    }
    CvvdpCase out;
    std::string over_colour;
    for (size_t i = 1; i < words.size(); ++i) {
      if (words[i].ends_with("fps"))
        out.options.fps = std::stod(words[i]);
      else if (words[i] == "symmetric")
        out.options.padding = Padding::symmetric;
      else if (words[i].starts_with("over_"))
        over_colour = words[i].substr(5);
      else if (words[i] != "alpha_dropped")
        out.display = display(words[i]);
    }
    if (!pictures(words[0], all().at(key).value("files", nlohmann::json::object()), out)) return std::nullopt;
    if (!over_colour.empty()) {
      const uint8_t v = over_colour == "black" ? 0 : over_colour == "white" ? 255 : 128;
      for (auto* side : {&out.reference, &out.test}) (*side)[0] = composited(std::get<Image8>((*side)[0]), v);
    }
    return out;
  }

 private:
  // Source-over on the encoded values, rounded to the nearest: these cases were made so.
  static Image8 composited(const Image8& in, uint8_t colour) {
    Image8 out(in.width, in.height, 3);
    for (size_t i = 0; i < out.data.size(); ++i) {
      const unsigned a = in.data[i / 3 * 4 + 3];
      out.data[i] = static_cast<uint8_t>((in.data[i / 3 * 4 + i % 3] * a + colour * (255 - a) + 127) / 255);
    }
    return out;
  }

  static bool add(std::vector<AnyImage>& side, const std::string& name) {
    auto image = ground_truth_picture(name);
    if (image) side.push_back(std::move(*image));
    return image.has_value();
  }

  static bool pictures(const std::string& name, const nlohmann::json& files, CvvdpCase& out) {
    if (files.contains("on_in_frames")) return blocks(files, out);
    if (files.contains("test"))
      return add(out.reference, "cvvdp/" + files["ref"].get<std::string>()) &&
             add(out.test, "cvvdp/" + files["test"].get<std::string>());
    if (name.starts_with("sequence")) return sequence(name, out);
    if (name == "p14_tiled_4x4_1920x1080") {
      if (!pictures("p14_render_alias", {}, out)) return false;
      for (auto* side : {&out.reference, &out.test}) (*side)[0] = tiled(std::get<Image8>((*side)[0]), 4);
      return true;
    }
    const bool high_range = name.starts_with("h0");
    const std::string folder = high_range ? "hdr/" : "images/";
    const std::string ending = high_range ? ".exr" : ".png";
    return add(out.reference, folder + name + "_ref" + ending) && add(out.test, folder + name + "_test" + ending);
  }

  static bool blocks(const nlohmann::json& files, CvvdpCase& out) {
    const auto on = ground_truth_picture("cvvdp/" + files["on"].get<std::string>());
    const auto off = ground_truth_picture("cvvdp/" + files["off"].get<std::string>());
    if (!on || !off) return false;
    const auto frames = files["on_in_frames"].get<std::vector<int>>();
    for (int f = 0; f < 24; ++f) {
      out.reference.push_back(*off);
      out.test.push_back(std::find(frames.begin(), frames.end(), f) != frames.end() ? *on : *off);
    }
    return true;
  }

  static Image8 tiled(const Image8& in, int times) {
    Image8 out(in.width * times, in.height * times, in.channels);
    const auto channels = static_cast<size_t>(in.channels);
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x) std::copy_n(in.at(x % in.width, y % in.height), channels, out.at(x, y));
    return out;
  }

  // The sequence with a pop, and what was made of it.
  static bool sequence(const std::string& name, CvvdpCase& out) {
    std::vector<int> frames(16);
    for (int f = 0; f < 16; ++f) frames[static_cast<size_t>(f)] = f;
    if (name == "sequence_reversed_time") std::reverse(frames.begin(), frames.end());
    if (name == "sequence_x4_64frames")
      for (int f = 16; f < 64; ++f) frames.push_back(f % 16);
    if (name == "sequence_frame08_as_image") frames = {8};
    if (name == "sequence_frame15_as_image") frames = {15};
    if (name == "sequence_frame08_static_x16") frames.assign(16, 8);
    if (name == "sequence_frames08_09_two_frames") frames = {8, 9};
    if (name == "sequence_first5") frames = {6, 7, 8, 9, 10};
    const std::string test = name == "sequence_ref_vs_ref" ? "ref" : "test";
    return std::all_of(frames.begin(), frames.end(), [&](int f) {
      return add(out.reference, fmt::format("sequence/ref_{:02}.png", f)) &&
             add(out.test, fmt::format("sequence/{}_{:02}.png", test, f));
    });
  }

  nlohmann::json expected_;
};

inline CvvdpResult score(const CvvdpCase& one) {
  Cvvdp metric(one.display, one.options);
  for (size_t f = 0; f < one.reference.size(); ++f)
    std::visit(
        [&](const auto& reference) {
          using T = std::decay_t<decltype(reference)>;
          if constexpr (!std::is_same_v<T, ImageU32>) metric.take(reference, std::get<T>(one.test[f]));
        },
        one.reference[f]);
  return metric.finish();
}

}  // namespace crowdbench::metrics
