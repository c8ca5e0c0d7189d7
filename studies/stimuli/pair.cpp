#include "studies/stimuli/pair.h"

#include "core/error.h"
#include "core/hash.h"
#include "core/json.h"
#include "core/progress.h"
#include "core/version.h"
#include "renderers/frame/capture.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"
#include "scene/scenario/scenario_writer.h"
#include "studies/stimuli/crowd_clip.h"

namespace crowdbench::studies {
namespace {

Json manifest(const gl::Context& context, const PairRequest& request, const Pair& pair, uint64_t ticks) {
  const auto side = [&](bool is_a) {
    return Json{{"configuration", is_a ? "a" : "b"}, {"representation", (is_a ? request.a : request.b).text()}};
  };
  const scene::Scenario& scenario = request.scenario;
  const std::string toml = scene::to_toml(scenario);
  const auto& [red, green, blue] = request.style.bar_colour;
  Json json;
  json["format"] = "crowdbench-pair-1";
  json["crowdbench"] = fmt::format("{} ({})", version(), git_revision());
  json["clip"] = pair.clip.files[0].path.filename().string();
  json["sha256"] = pair.clip.files[0].sha256;
  json["top"] = side(pair.a_on_top);
  json["bottom"] = side(!pair.a_on_top);
  json["side_rule"] =
      fmt::format("a is on top when the highest bit of random_bits(seed, pair, {:#x}) is 0", kSidePurpose);
  json["pair"] = request.pair;
  json["seed"] = scenario.seed;
  json["equal"] = pair.equal;
  json["agents"] = request.crowd.size();
  json["half"] = {{"width", scenario.width},
                  {"height", scenario.height},
                  {"samples", scenario.antialiasing.samples},
                  {"supersample", scenario.antialiasing.supersample}};
  json["bar"] = {{"height", request.style.bar_height},
                 {"colour", fmt::format("#{:02x}{:02x}{:02x}", red, green, blue)}};
  json["ticks_per_frame"] = ticks;
  json["scenario"] = {{"name", scenario.name}, {"sha256", sha256_hex(toml)}, {"toml", toml}};
  json["renderer"] = {{"vendor", context.vendor()},
                      {"name", context.renderer()},
                      {"version", context.version()},
                      {"software", context.is_software()}};
  json["video"] = clip_json(pair.clip);
  return json;
}

}  // namespace

Pair export_pair(gl::Context& context, const scene::Cast& cast, const PairRequest& request,
                 const std::filesystem::path& target) {
  const scene::Scenario& scenario = request.scenario;
  const uint64_t ticks = ticks_per_frame(scenario, request.clip.fps, "--fps");
  if (request.frames == 0) throw Error("frames", "a clip needs at least one frame");
  Pair pair;
  pair.a_on_top = first_on_top(scenario.seed, request.pair);

  const StackSize size = stack_size(scenario.width, scenario.height, request.style);
  ClipWriter writer(target, size.width, size.height, request.clip);
  {
    renderers::Renderer renderer(context, cast);
    const auto a = renderers::make_representation({context, cast}, request.a);
    const auto b = renderers::make_representation({context, cast}, request.b);
    renderers::Representation& top = pair.a_on_top ? *a : *b;
    renderers::Representation& bottom = pair.a_on_top ? *b : *a;
    Progress progress("drawing " + target.filename().string(), request.frames);
    for (size_t f = 0; f < request.frames; ++f) {
      const uint64_t tick = f * ticks;
      const scene::Camera camera = scenario.camera.at(static_cast<double>(tick) / scenario.tick_rate);
      const scene::Frame frame = scene::make_frame(scenario, cast, request.crowd, camera, tick);
      const Image8 upper = renderer.capture(frame, top).colour;
      const Image8 lower = renderer.capture(frame, bottom).colour;
      pair.equal = pair.equal && upper == lower;
      writer.add(stack_vertically(upper, lower, request.style));
      progress.advance();
    }
  }
  pair.clip = writer.finish();
  pair.manifest = manifest(context, request, pair, ticks).dump(2) + "\n";
  if (pair.clip.accurate) write_file(std::filesystem::path(target).replace_extension(".json"), pair.manifest);
  return pair;
}

}  // namespace crowdbench::studies
