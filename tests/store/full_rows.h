// Rows with a value in every field, each different from all others of its row, so that no two columns can be taken for
// each other; their literal twins are in the tests.
#pragma once
#include <limits>

#include "store/rows.h"

namespace crowdbench {

inline RunRow full_run() {
  RunRow run;
  run.command = "bench";
  run.arguments = "crowdbench bench --agents 1,10";
  run.started = "2026-01-02T03:04:05Z";
  run.version = "0.1.0";
  run.revision = "abc123";
  run.scenario_name = "a </script> name";
  run.scenario = "seed = 7\nname = \"it's\"\n";
  run.scenario_hash = "00ff";
  run.seed = std::numeric_limits<uint64_t>::max();
  run.order_seed = std::numeric_limits<uint64_t>::max() - 1;
  run.gl_vendor = "Mesa";
  run.gl_renderer = "llvmpipe";
  run.gl_version = "4.5";
  run.software = true;
  run.headline = "wall";
  run.cpu_model = "A CPU";
  run.cpu_mhz = 2599.5;
  run.cpu_scaling_enabled = false;
  run.cpu_threads = 2;
  run.os = "Linux 6";
  run.timer_cost_ns = 250.5;
  return run;
}

// run: its id.
inline MeasurementRow full_measurement(int64_t run) {
  MeasurementRow row;
  row.run = run;
  row.key = {"flat:views=64", "mannequin + robot.glb", 250, 640, 480, 0.15};
  row.status = Status::invalid;
  row.reason = "nothing moved";
  row.reference = "mesh";
  row.achieved_occupancy = 0.1512;
  row.covered_px = 46000;
  row.reference_px = 46100;
  row.moved_px = 900;
  row.touched_px = 50000;
  row.agents_wholly = 240;
  row.agents_partly = 8;
  row.agents_off = 3;
  row.triangles_per_agent = 7;
  row.rounds = 24;
  row.warmup_frames = 4;
  row.settled = true;
  row.frame_ns = TimeSummary{1.5, 2.5, 3.5, 4.5, 5.5, 6.5};
  row.cpu_ns = TimeSummary{11.5, 12.5, 13.5, 14.5, 15.5, 16.5};
  row.main_cpu_ns = TimeSummary{21.5, 22.5, 23.5, 24.5, 25.5, 26.5};
  row.gpu_ns = TimeSummary{31.5, 32.5, 33.5, 34.5, 35.5, 36.5};
  row.low_1_percent_fps = 333.25;
  row.vertices_shaded = 1001;
  row.primitives = 1002;
  row.fragments = 1003;
  row.samples_passed = 1004;
  row.texture_bytes = uint64_t{5} << 30;
  row.buffer_bytes = 2001;
  row.upload_bytes_per_frame = 2002;
  row.disk_bytes = 2003;
  row.shared_bytes = 2004;
  row.bake_seconds = 1.25;
  row.bake_load_seconds = 0.75;
  row.bake_cached = false;
  row.samples = {{5, 6, 1000000, 3000000, 2000000, 77}, {7, 8, 1000001, 3000001, 2000001, 0}};
  return row;
}

inline RatioRow full_ratio(int64_t run) {
  return {0, run, "floor", {"flat", "mannequin", 250, 640, 480, 0.15}, "mesh", "cpu", 12.5, 11.5, 13.5, 20};
}

inline ControlRow full_control(int64_t run) {
  return {0, run, {"mesh", "mannequin", 251, 641, 481, 0.16}, "wall", 1.25, 0.75, 1.75, 0.5, 0.03125, 21};
}

inline ComparisonRow full_comparison(int64_t run) {
  ComparisonRow row;
  row.run = run;
  row.kind = "agent";
  row.representation = "flat";
  row.reference = "mesh";
  row.character = "mannequin";
  row.agents = 9;
  row.requested_occupancy = 0.25;
  row.tick = 11;
  row.height_px = 64.5;
  row.azimuth_deg = 45.5;
  row.elevation_deg = 15.5;
  row.clip = "walk";
  row.time = 0.75;
  row.agent = 12;
  row.distance = 23.5;
  row.pixels_per_texel = 0.5;
  row.alone_px = 1300;
  row.visible_px = 1200;
  row.state = "counted";
  row.display = "standard_fhd: ...";
  row.display_given = true;
  row.scores = {{"psnr", std::numeric_limits<double>::infinity(), ""},
                {"ssim", std::nullopt, "smaller than 11 pixels"}};
  return row;
}

inline CurveRow full_curve(int64_t run) {
  CurveRow row;
  row.run = run;
  row.representation = "flat";
  row.reference = "mesh";
  row.character = "mannequin";
  row.score = "flip";
  row.against = "height_px";
  row.points = 401;
  row.agents = 201;
  row.rank_correlation = -0.25;
  row.display = "standard_fhd: ...";
  row.display_given = true;
  row.bins = {{0, 1.5, 2.5, 3.5, 4.5, 5.5, std::numeric_limits<double>::infinity(), 200, 101},
              {1, 11.5, 12.5, 13.5, 14.5, 15.5, 16.5, 202, 100}};
  return row;
}

inline ThresholdRow full_threshold(int64_t run, int64_t curve) {
  return {0, run, curve, 0.125, "reached", 20.5, 18.5, 22.5};
}

inline SweepRow full_sweep() {
  SweepRow row;
  row.plan_name = "textures";
  row.plan_hash = "0123456789abcdef";
  row.plan = "[axes]\nseed = [1]\n";
  row.conditions = 31;
  row.repetitions = 3;
  row.points = uint64_t{7} << 33;
  row.shard = 5;
  row.shards = 8;
  row.revision = "abc123";
  row.gl_renderer = "llvmpipe";
  row.gl_version = "4.5";
  return row;
}

inline SweepPointRow full_sweep_point(int64_t sweep, int64_t run, int64_t measurement, int64_t comparison) {
  SweepPointRow row;
  row.sweep = sweep;
  row.run = run;
  row.condition = 12;
  row.repetition = 2;
  row.role = "point";
  row.point_key = "fedcba9876543210";
  row.representation = "flat:texels=64";
  row.settings = R"({"seed":"1"})";
  row.state = "invalid";
  row.reason = "nothing moved";
  row.measurement = measurement;
  row.comparison = comparison;
  row.ratio = 1.25;
  row.ratio_low = 1.125;
  row.ratio_high = 1.5;
  row.seconds = 2.75;
  return row;
}

inline CauseRangeRow full_cause_range(int64_t run) {
  CauseRangeRow row;
  row.run = run;
  row.representation = "flat";
  row.reference = "mesh";
  row.character = "mannequin";
  row.unit = "agent";
  row.from = 15;
  row.below = 60;
  row.units = 21;
  row.total = 123456789;
  row.residue = 0.0625;
  row.dominant = "view";
  row.share_low = 0.375;
  row.share_high = 0.5;
  row.words = "below 60 pixels: the stored view";
  row.shares = {{"silhouette", "the silhouette", -0.25}, {"view", "the stored view", 0.4375}};
  return row;
}

inline PopRow full_pop(int64_t run) {
  PopRow row;
  row.run = run;
  row.representation = "hybrid(mesh,flat)";
  row.character = "mannequin";
  row.from = "mesh";
  row.to = "flat";
  row.agent = 12;
  row.tick = 31;
  row.frames = 4;
  row.complete = false;
  row.distance = 20.5;
  row.pixels = 321;
  row.worst_tick = 33;
  row.display = "standard_fhd: ...";
  row.scores = {{"pop_flip", 0.125}, {"pop_luma", std::nullopt}};
  return row;
}

inline TuningRow full_tuning(int64_t run) {
  TuningRow row;
  row.run = run;
  row.character = "mannequin + fox.glb";
  row.score = "ssim";
  row.threshold = 0.875;
  row.pop_score = "psnr";
  row.pop_threshold = 31.5;
  row.budget_ns = 8e6;
  row.representation = "hybrid(mesh,flat,height=24)";
  row.reason = "a made-up one";
  row.agents = 321.5;
  row.saving = 3.5;
  row.saving_low = 3.25;
  row.saving_high = 3.75;
  row.promised = 2.5;
  row.promised_low = 2.25;
  row.promised_high = 2.75;
  row.lenses_hold = true;
  row.proof_holds = false;
  row.display = "standard_fhd: ...";
  row.display_given = true;
  row.switches = {{0, "mesh", "flat", 24.5, 20.5, 28.5, 0.9375, false, 12.25, 0.5, 1.5, 0.125, 0.75},
                  {1, "flat", "relief", 12.5, {}, {}, 0, true, 30.25, {}, {}, 0, {}}};
  return row;
}

inline StabilityCaseRow full_stability_case(int64_t run) {
  StabilityCaseRow row;
  row.run = run;
  row.name = "world_1e7";
  row.group = "world";
  row.representation = "flat:views=hemi-4";
  row.measured = 0.25;
  row.bound = 0.5;
  row.unit = "grey levels";
  row.pass = true;
  row.bound_seen = true;
  row.small = true;
  row.place = "pixel (1, 2)";
  row.expected = "(3, 4, 5)";
  row.got = "(6, 7, 8)";
  row.note = "one of four";
  row.error = "a made-up one";
  return row;
}

inline StudyParticipantRow full_participant() {
  StudyParticipantRow row;
  row.study = "0a1b";
  row.participant = "2c3d";
  row.list = "4";
  row.state = "finished";
  row.token = "4e5f";
  row.started = "2026-01-02T03:04:05Z";
  row.ended = "2026-01-02T03:34:05Z";
  row.pixels_per_degree = 36.5;
  row.pixels_per_degree_se = 3.25;
  row.begun = R"({"t001":2})";
  return row;
}

inline StudyAnswerRow full_answer(int64_t participant) {
  StudyAnswerRow row;
  row.participant = participant;
  row.item = "t012";
  row.kind = "catch";
  row.stimulus = "s003";
  row.block = 2;
  row.answer = "cannot-tell";
  row.rt = 812.5;
  row.replays = 1;
  row.frames_dropped = 3;
  row.hidden = 4;
  row.restarts = 5;
  row.received = "2026-01-02T03:05:05Z";
  row.data = R"({"item":"t012"})";
  return row;
}

inline PictureRow full_picture(int64_t run, int64_t comparison) {
  return {0, run, comparison, "difference", "a caption", 12, 13, {0, 1, 2, 255}};
}

}  // namespace crowdbench
