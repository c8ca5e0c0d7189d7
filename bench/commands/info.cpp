#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "core/json.h"
#include "core/version.h"
#include "renderers/gl/counters.h"
#include "renderers/representation.h"

namespace crowdbench::bench {
namespace {

// What a type can do, and what its floor is, in words.
std::vector<std::string> abilities(const renderers::RepresentationType& type) {
  std::vector<std::string> words;
  if (type.reference) words.emplace_back("the reference of all comparisons");
  if (!stands_alone(type)) words.push_back(fmt::format("made of {} others", type.components));
  if (type.view_sampling != nullptr) words.emplace_back("stores views (bake --audit)");
  if (type.required_by) words.emplace_back("leaves out what a scenario does not show (bake --required-by)");
  if (const auto views = debug_views(type); !views.empty())
    words.push_back(fmt::format("debug views {}", fmt::join(views, ", ")));
  words.push_back("its floor is " + type.floor);
  return words;
}

Json representations_json() {
  Json out = Json::array();
  for (const renderers::RepresentationType& type : renderers::representation_types()) {
    Json options = Json::array();
    for (const renderers::OptionDoc& o : renderers::option_docs(type))
      options.push_back({{"key", o.key}, {"values", o.values}, {"default", o.default_value}, {"meaning", o.meaning}});
    out.push_back({{"name", type.name},
                   {"summary", type.summary},
                   {"example", example_spec(type)},
                   {"reference", type.reference},
                   {"stands_alone", stands_alone(type)},
                   {"components", type.components},
                   {"stores_views", type.view_sampling != nullptr},
                   {"required_by", type.required_by},
                   {"debug_views", debug_views(type)},
                   {"floor", type.floor},
                   {"suits",
                    {{"new_clips", type.suits.new_clips},
                     {"close_by", type.suits.close_by},
                     {"from_above", type.suits.from_above},
                     {"shadows", type.suits.shadows}}},
                   {"options", options}});
  }
  return out;
}

void print_representations() {
  for (const renderers::RepresentationType& type : renderers::representation_types()) {
    fmt::print("{}: {}\n", type.name, type.summary);
    fmt::print("  {}\n", fmt::join(abilities(type), "; "));
    for (const renderers::OptionDoc& o : renderers::option_docs(type))
      fmt::print("  {:<12} {:<24} default {:<10} {}\n", o.key, o.values, o.default_value, o.meaning);
  }
}

Json device_json(const std::string& device) {
  Json devices = Json::array();
  for (const gl::Device& d : gl::list_devices())
    devices.push_back({{"index", d.index}, {"name", d.name}, {"software", d.software}});
  gl::ContextOptions options;
  options.device = device;
  gl::Context context(options);
  const gl::TimerTrust timer = gl::test_gpu_timer(context);
  const gl::Limits& l = context.limits();
  return {
      {"version", version()},
      {"revision", git_revision()},
      {"devices", devices},
      {"platform", context.platform()},
      {"vendor", context.vendor()},
      {"renderer", context.renderer()},
      {"gl_version", context.version()},
      {"software", context.is_software()},
      {"warnings", context.warnings()},
      {"limits",
       {{"texture_size", l.texture_size},
        {"array_layers", l.array_layers},
        {"viewport_size", l.viewport_size},
        {"storage_block_bytes", l.storage_block},
        {"uniform_block_bytes", l.uniform_block}}},
      {"pipeline_statistics", context.has_extension("GL_ARB_pipeline_statistics_query")},
      {"gpu_timer",
       {{"trusted", timer.trusted}, {"gpu_ns", timer.gpu_ns}, {"wall_ns", timer.wall_ns}, {"reason", timer.reason}}}};
}

void print_device(const Json& j) {
  fmt::print("crowdbench {} ({})\n", j.at("version").text(), j.at("revision").text());
  fmt::print("EGL devices:\n");
  for (const Json& d : j.at("devices").elements())
    fmt::print("  {}  {}{}\n", d.at("index").integer(), d.at("name").text(),
               d.at("software").truth() ? " (software)" : "");
  if (j.at("devices").empty()) fmt::print("  none\n");
  for (const Json& w : j.at("warnings").elements()) fmt::print("warning: {}\n", w.text());
  fmt::print("drawing on {} by {}\n", j.at("renderer").text(), j.at("vendor").text());
  fmt::print("  {}, through {}\n", j.at("gl_version").text(), j.at("platform").text());
  if (j.at("software").truth())
    fmt::print("  a software rasteriser: times on it say nothing of a GPU; ratios of CPU time are the headline\n");
  const Json& l = j.at("limits");
  fmt::print("limits: textures {} px a side, {} layers; pictures {} px a side; storage block {} bytes\n",
             l.at("texture_size").integer(), l.at("array_layers").integer(), l.at("viewport_size").integer(),
             l.at("storage_block_bytes").integer());
  fmt::print("pipeline statistics: {}\n", j.at("pipeline_statistics").truth() ? "yes" : "no");
  fmt::print("GPU timer: {}: {}\n", j.at("gpu_timer").at("trusted").truth() ? "trusted" : "not trusted",
             j.at("gpu_timer").at("reason").text());
}

}  // namespace

void add_info(Command& app, Run& run) {
  Command* command = app.add_subcommand("info", "Say which device draws and what it can do, or list representations");
  command->footer(
      "Examples:\n  crowdbench info\n  crowdbench info --device software --json\n"
      "  crowdbench info --representations");
  struct Options {
    bool json = false;
    bool representations = false;
    std::string device;
  };
  auto options = std::make_shared<Options>();
  add_json_option(*command, options->json);
  command->add_flag("--representations", options->representations,
                    "list the representations with their options (asks no device)");
  add_device_option(*command, options->device);
  command->callback([options, &run] {
    run = [options] {
      if (options->representations) {
        if (options->json)
          fmt::print("{}\n", representations_json().dump(2));
        else
          print_representations();
        return 0;
      }
      const Json facts = device_json(options->device);
      if (options->json)
        fmt::print("{}\n", facts.dump(2));
      else
        print_device(facts);
      return 0;
    };
  });
}

}  // namespace crowdbench::bench
