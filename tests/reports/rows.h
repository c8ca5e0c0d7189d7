// Made-up rows for the tests of reports: never measured, never shipped.
#pragma once
#include <cmath>

#include "core/error.h"
#include "reports/model/score_doc.h"
#include "reports/page/libraries.h"
#include "store/store.h"

namespace crowdbench::reports {

// Whether pages can be made: npm's packages were there at configure time.
inline bool has_libraries() {
  try {
    return !chart_libraries().empty();
  } catch (const Error&) {
    return false;
  }
}

inline RunRow made_up_run() {
  RunRow run;
  run.id = 1;
  run.command = "bench";
  run.arguments = "bench made-up.toml";
  run.started = "2026-01-02T03:04:05Z";
  run.version = "0.0.0";
  run.revision = "made-up";
  run.scenario_name = "plaza </script><script>alert(1)</script>";
  run.scenario = "# made up & <b>bold</b>\nseed = 1\n";
  run.scenario_hash = "beef";
  run.seed = 1;
  run.gl_vendor = "Nobody";
  run.gl_renderer = "made-up rasteriser";
  run.gl_version = "4.5";
  run.software = true;
  run.headline = "cpu";
  run.cpu_model = "A CPU @ \"3\" GHz";
  run.cpu_threads = 2;
  run.os = "Linux";
  run.timer_cost_ns = 200;
  return run;
}

inline TimeSummary spread(double median_ns) {
  return {median_ns, 0.95 * median_ns, 1.08 * median_ns, 0.9 * median_ns, 1.3 * median_ns, 1.5 * median_ns};
}

// What the program would say of the scores below, and of one that no row has.
inline std::vector<ScoreDoc> made_up_scores() {
  std::vector<ScoreDoc> docs(6);
  docs[0] = {"silhouette_iou", "silhouette IoU", "", "overlap", true, 3, 1, true, true, false};
  docs[1] = {"ssim", "SSIM", "", "similarity", true, 3, 1, true, false, false};
  docs[2] = {"ssim_union", "SSIM in the figure", "", "similarity", true, 3, 1, false, true, false};
  docs[3] = {"psnr", "PSNR", "dB", "signal to noise", true, 1, INFINITY, false, false, false};
  docs[4] = {"mae", "mean absolute error", "code values", "mean of abs(a - b)", false, 2, 0, false, false, true};
  docs[5] = {"never_made", "a score of another day", "", "nothing", true, 3, 1, true, true, false};
  return docs;
}

// mesh: 0.1 ms an agent; flat: 1 ms + 0.001 ms an agent, so that they cross near 10 agents; 16:9 of the wall clock.
inline StoreContents made_up_contents() {
  StoreContents all;
  all.runs.push_back(made_up_run());
  int64_t id = 0;
  for (const double occupancy : {0.15, 0.9})
    for (const uint32_t agents : {1U, 10U, 100U, 250U, 1000U})
      for (const char* name : {"mesh", "flat"}) {
        const bool mesh = std::string(name) == "mesh";
        MeasurementRow row;
        row.id = ++id;
        row.run = 1;
        row.key = {name, "mannequin", agents, 640, 480, occupancy};
        row.reference = "mesh";
        if (mesh && agents == 1000 && occupancy > 0.5) {
          row.status = Status::stopped;
          row.reason = "at 250 agents a frame took 1.2 s, over the budget of 1 s";
          all.measurements.push_back(row);
          continue;
        }
        const double ns = (mesh ? 1e5 * agents : 1e6 + 1e3 * agents) * (occupancy > 0.5 ? 1.5 : 1.0);
        row.cpu_ns = spread(ns);
        row.frame_ns = spread(ns * 0.6);
        row.main_cpu_ns = spread(ns * 0.4);
        row.low_1_percent_fps = 1e9 / (ns * 0.9);
        row.rounds = 24;
        row.warmup_frames = 5;
        row.settled = true;
        row.achieved_occupancy = occupancy + 0.002;
        row.covered_px = static_cast<uint64_t>(occupancy * 307200);
        row.reference_px = row.covered_px;
        row.moved_px = 2000;
        row.triangles_per_agent = mesh ? 5000 : 2;
        row.vertices_shaded = (mesh ? 3000 : 4) * uint64_t{agents};
        row.primitives = (mesh ? 5000 : 2) * uint64_t{agents};
        row.texture_bytes = mesh ? 5592404 : 178956970;
        row.buffer_bytes = mesh ? 300000 : 20000;
        row.upload_bytes_per_frame = 48 * uint64_t{agents};
        row.shared_bytes = 123456;
        row.bake_seconds = mesh ? 0.01 : 3.2;
        row.bake_cached = false;
        if (agents == 1 && occupancy > 0.5) {
          row.status = Status::unreachable;
          row.reason = "1 agents cover 62 % at most, 90 % were asked for";
          row.frame_ns = row.cpu_ns = row.main_cpu_ns = std::nullopt;
          row.rounds = 0;
          all.measurements.push_back(row);
          continue;
        }
        for (int round = 0; round < 3; ++round)
          row.samples.push_back({round, static_cast<uint64_t>(round), static_cast<int64_t>(ns * 0.6) + round * 1000,
                                 static_cast<int64_t>(ns) + round * 2000, 1, std::nullopt});
        if (!mesh) {
          const double ratio = 1e5 * agents / (1e6 + 1e3 * agents);
          if (!(agents == 1000 && occupancy > 0.5))
            all.ratios.push_back({id, 1, "speed", row.key, "mesh", "cpu", ratio, ratio * 0.97, ratio * 1.04, 24});
        }
        all.ratios.push_back(
            {id + 100, 1, "floor", row.key, std::string(name) + ":floor=1", "cpu", 1.12, 1.1, 1.15, 24});
        all.measurements.push_back(row);
      }
  for (const double height : {16.0, 64.0, 256.0})
    for (const double azimuth : {0.0, 45.0, 90.0}) {
      ComparisonRow row;
      row.id = ++id;
      row.run = 1;
      row.kind = "agent";
      row.representation = "flat";
      row.reference = "mesh";
      row.character = "mannequin";
      row.height_px = height;
      row.azimuth_deg = azimuth;
      row.elevation_deg = 0.0;
      row.clip = "walk";
      row.time = 0.25;
      const double iou = 0.99 - 0.01 * std::log2(height) - azimuth / 1000;
      row.scores = {{"silhouette_iou", iou, ""},
                    {"ssim", iou - 0.05, ""},
                    {"ssim_union", iou - 0.1, ""},
                    {"psnr", std::nullopt, "made up"},
                    {"boundary_px_mean", 0.5, ""}};
      all.comparisons.push_back(row);
    }
  ComparisonRow crowd;
  crowd.id = ++id;
  crowd.run = 1;
  crowd.kind = "crowd";
  crowd.representation = "flat";
  crowd.reference = "mesh";
  crowd.character = "mannequin";
  crowd.agents = 100;
  crowd.requested_occupancy = 0.15;
  crowd.scores = {{"ssim", 0.95, ""}, {"psnr", INFINITY, ""}, {"mae", 1.25, ""}};
  all.comparisons.push_back(crowd);
  // One grey pixel.
  const std::vector<uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  for (const char* role : {"reference", "test", "difference"})
    all.pictures.push_back({++id, 1, crowd.id, role, role, 64, 48, png});
  return all;
}

}  // namespace crowdbench::reports
