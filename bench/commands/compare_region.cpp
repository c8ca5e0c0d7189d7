#include "bench/commands/compare_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>
#include <variant>

#include "core/error.h"
#include "core/json.h"

namespace crowdbench::bench {
namespace {

struct Rectangle {
  int x = 0, y = 0, width = 0, height = 0;
};

Rectangle parse_rectangle(const std::string& text) {
  std::array<int, 4> n{};
  const char* at = text.data();
  const char* const end = at + text.size();
  bool fine = true;
  for (size_t i = 0; fine && i < n.size(); ++i) {
    const auto [next, fault] = std::from_chars(at, end, n[i]);
    const bool last = i + 1 == n.size();
    fine = fault == std::errc{} && n[i] >= (i < 2 ? 0 : 1) && (last ? next == end : next < end && *next == ',');
    at = fine && !last ? next + 1 : next;
  }
  if (!fine)
    throw Error("--ignore", fmt::format("'{}' is not a rectangle", printable(text)),
                "write x,y,width,height in pixels from the upper left corner: 0,0,640,24");
  return {n[0], n[1], n[2], n[3]};
}

void leave_out(const std::string& text, metrics::Mask& counted) {
  const Rectangle r = parse_rectangle(text);
  if (r.x >= counted.width || r.y >= counted.height)
    throw Error("--ignore", fmt::format("'{}' lies outside the picture", printable(text)),
                fmt::format("the picture is {} x {} pixels", counted.width, counted.height));
  const int right = r.width < counted.width - r.x ? r.x + r.width : counted.width;
  const int bottom = r.height < counted.height - r.y ? r.y + r.height : counted.height;
  for (int y = r.y; y < bottom; ++y) std::fill(counted.at(r.x, y), counted.at(r.x, y) + (right - r.x), uint8_t{0});
}

// Any channel but alpha above 0 counts the pixel in. Returns in how many pixels alpha, where the mask has a say of it
// at all, says otherwise.
template <typename T>
uint64_t apply_mask(const Image<T>& mask, metrics::Mask& counted) {
  const int colours = std::min(mask.channels, 3);
  const T full = std::is_integral_v<T> ? std::numeric_limits<T>::max() : T{1};
  bool opaque = true;
  uint64_t otherwise = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const T* pixel = mask.at(x, y);
      const bool black = std::all_of(pixel, pixel + colours, [](T v) { return v == 0; });
      if (black) *counted.at(x, y) = 0;
      if (mask.channels != 4) continue;
      opaque = opaque && pixel[3] >= full;
      otherwise += black != (pixel[3] == 0) ? 1 : 0;
    }
  return opaque ? 0 : otherwise;
}

void read_mask(const std::string& path, CompareRegion& region) {
  metrics::Mask& counted = region.counted;
  const AnyImage picture = read_image(path);
  std::visit(
      [&](const auto& mask) {
        if (mask.width != counted.width || mask.height != counted.height)
          throw Error(path,
                      fmt::format("is {} x {} pixels, the pictures are {} x {}", mask.width, mask.height, counted.width,
                                  counted.height),
                      "give a mask of their size: white counts, black does not");
        if (const uint64_t otherwise = apply_mask(mask, counted))
          region.notes.push_back(
              fmt::format("{}: colours decide what counts, black or not; alpha, which would decide otherwise in {} of "
                          "{} pixels, has no say",
                          printable(path), otherwise, mask.pixels()));
      },
      picture);
}

}  // namespace

std::optional<CompareRegion> compare_region(const RegionOptions& options, int width, int height) {
  if (!options.given()) return std::nullopt;
  CompareRegion region;
  region.counted = metrics::Mask(width, height, 1);
  std::fill(region.counted.data.begin(), region.counted.data.end(), uint8_t{255});
  for (const std::string& text : options.ignore) leave_out(text, region.counted);
  if (!options.mask.empty()) read_mask(options.mask, region);
  region.pixels = static_cast<uint64_t>(std::ranges::count_if(region.counted.data, [](uint8_t v) { return v != 0; }));
  if (region.pixels == 0)
    throw Error(options.mask.empty() ? "--ignore" : "--mask", "leaves no pixel to compare",
                region.notes.empty() ? "leave out less" : "draw the mask in black and white: its alpha has no say");
  return region;
}

Json region_json(const RegionOptions& options, const CompareRegion& region) {
  Json out = {{"pixels", region.pixels}, {"ignore", Json::array()}};
  for (const std::string& text : options.ignore) {
    const Rectangle r = parse_rectangle(text);
    out["ignore"].push_back({r.x, r.y, r.width, r.height});
  }
  out["mask"] = options.mask.empty() ? Json() : Json(options.mask);
  return out;
}

namespace {

// What is no number there is 0 in both pictures: it does not count, and no score can be made with it.
void finite_outside(const CompareRegion& region, AnyImage& picture) {
  auto* floats = std::get_if<ImageF>(&picture);
  if (!floats) return;
  for (int y = 0; y < floats->height; ++y)
    for (int x = 0; x < floats->width; ++x) {
      float* pixel = floats->at(x, y);
      if (*region.counted.at(x, y) != 0) continue;
      if (std::any_of(pixel, pixel + floats->channels, [](float v) { return !std::isfinite(v); }))
        std::fill_n(pixel, floats->channels, 0.0F);
    }
}

}  // namespace

void equal_outside(const CompareRegion& region, AnyImage& reference, AnyImage& test) {
  finite_outside(region, reference);
  std::visit(
      [&](auto& to) {
        const auto& from = std::get<std::decay_t<decltype(to)>>(reference);
        for (int y = 0; y < to.height; ++y)
          for (int x = 0; x < to.width; ++x) {
            if (*region.counted.at(x, y) != 0) continue;
            for (int c = 0; c < to.channels; ++c) to.at(x, y)[c] = from.at(x, y)[from.channels < 3 ? 0 : c % 3];
          }
      },
      test);
}

}  // namespace crowdbench::bench
