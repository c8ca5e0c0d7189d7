#include "bench/sweep/schedulers.h"

#include <fmt/format.h>

#include <array>
#include <cstdio>

#include "core/command_line.h"
#include "core/error.h"
#include "core/json.h"

namespace crowdbench::bench::sweep {
namespace {

// What stands before and after the number of a shard in its file's name.
std::pair<std::string, std::string> around_number(const std::filesystem::path& out, uint32_t shards) {
  std::filesystem::path stem = out;
  const std::string extension = out.extension().string();
  stem.replace_extension();
  return {stem.string() + "-", fmt::format("-of-{}{}", shards, extension)};
}

// Slurm's own lines are no shell: what would end or split one is left out of them.
std::string plain_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    out += plain ? c : '_';
  }
  return out.empty() ? "sweep" : out;
}

std::string first_line_of(const std::string& command) {
  FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
  std::string said;
  std::array<char, 512> buffer{};
  while (pipe != nullptr && std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) said += buffer.data();
  const bool fine = pipe != nullptr && ::pclose(pipe) == 0;
  const std::string line = said.substr(0, said.find('\n'));
  if (!fine || line.empty())
    throw Error("--submit", fmt::format("sbatch failed: {}", printable(said.empty() ? "it said nothing" : line)),
                "the scripts are written; hand them in with sbatch yourself");
  return line.substr(0, line.find(';'));  // "JOB;CLUSTER" where there are several clusters
}

}  // namespace

std::filesystem::path shard_file(const std::filesystem::path& out, uint32_t shard, uint32_t shards) {
  const auto [before, after] = around_number(out, shards);
  return fmt::format("{}{}{}", before, shard, after);
}

namespace {

std::string quoted_options(const ShardJobs& jobs) {
  std::string out;
  for (const std::string& option : jobs.options) out += " " + shell_quoted(option);
  return out;
}

}  // namespace

std::string slurm_array(const ShardJobs& jobs) {
  const auto [before, after] = around_number(jobs.out, jobs.shards);
  return fmt::format(R"(#!/bin/sh
# The shards of a sweep, one array task each. Handed in with: sbatch THIS_FILE
#SBATCH --job-name={name}
#SBATCH --array=1-{shards}
#SBATCH --output={name}-%a.log
#SBATCH --open-mode=append
# Two shards on one machine would disturb each other's times.
#SBATCH --exclusive
# A minute before its time is over the shard is told to end; it then exits with 75, without the condition in hand.
#SBATCH --signal=B:TERM@60
#SBATCH --requeue
{program} sweep {plan} --shard "$SLURM_ARRAY_TASK_ID/{shards}"{options} \
  --out {before}"$SLURM_ARRAY_TASK_ID"{after} &
shard=$!
trap 'kill -TERM "$shard"' TERM
wait "$shard"
status=$?
# The trap ends the first wait, with a status above 128.
if [ "$status" -gt 128 ]; then wait "$shard"; status=$?; fi
if [ "$status" -eq 75 ]; then exec scontrol requeue "$SLURM_JOB_ID"; fi
exit "$status"
)",
                     fmt::arg("name", plain_name(jobs.name)), fmt::arg("shards", jobs.shards),
                     fmt::arg("program", shell_quoted(jobs.program.string())),
                     fmt::arg("plan", shell_quoted(jobs.plan.string())), fmt::arg("options", quoted_options(jobs)),
                     fmt::arg("before", shell_quoted(before)), fmt::arg("after", shell_quoted(after)));
}

std::string slurm_merge(const ShardJobs& jobs) {
  std::string files;
  for (uint32_t shard = 1; shard <= jobs.shards; ++shard)
    files += " \\\n  " + shell_quoted(shard_file(jobs.out, shard, jobs.shards).string());
  return fmt::format(R"(#!/bin/sh
# Puts the shards together when all tasks have ended: sbatch --dependency=afterany:JOB THIS_FILE
# Status 3: shards are missing, and it says which. Hand the array in again: what is done is not done twice.
#SBATCH --job-name={name}_merge
#SBATCH --output={name}-merge.log
exec {program} merge {out}{files}
)",
                     fmt::arg("name", plain_name(jobs.name)), fmt::arg("program", shell_quoted(jobs.program.string())),
                     fmt::arg("out", shell_quoted(jobs.out.string())), fmt::arg("files", files));
}

std::string submit(const std::filesystem::path& array, const std::filesystem::path& merge) {
  const std::string job = first_line_of("sbatch --parsable " + shell_quoted(array.string()));
  const std::string after = first_line_of(
      fmt::format("sbatch --parsable --dependency=afterany:{} {}", shell_quoted(job), shell_quoted(merge.string())));
  return fmt::format("{}, {}", job, after);
}

std::string openjd_template(const ShardJobs& jobs) {
  const auto [before, after] = around_number(jobs.out, jobs.shards);
  Json shard_args =
      Json::array({"sweep", jobs.plan.string(), "--shard", fmt::format("{{{{Task.Param.Shard}}}}/{}", jobs.shards),
                   "--out", fmt::format("{}{{{{Task.Param.Shard}}}}{}", before, after)});
  for (const std::string& option : jobs.options) shard_args.push_back(option);
  Json merge_args = Json::array({"merge", jobs.out.string()});
  for (uint32_t shard = 1; shard <= jobs.shards; ++shard)
    merge_args.push_back(shard_file(jobs.out, shard, jobs.shards).string());
  const auto step_script = [](Json args) {
    Json run = Json::object();
    run["command"] = "{{Param.Crowdbench}}";
    run["args"] = std::move(args);
    Json script = Json::object();
    script["actions"]["onRun"] = std::move(run);
    return script;
  };
  Json program = Json::object();
  program["name"] = "Crowdbench";
  program["type"] = "PATH";
  program["objectType"] = "FILE";
  program["dataFlow"] = "NONE";
  program["default"] = jobs.program.string();
  Json range = Json::object();
  range["name"] = "Shard";
  range["type"] = "INT";
  range["range"] = fmt::format("1-{}", jobs.shards);
  Json shards = Json::object();
  shards["name"] = "Shards";
  shards["parameterSpace"]["taskParameterDefinitions"] = Json::array({range});
  shards["script"] = step_script(std::move(shard_args));
  Json merge = Json::object();
  merge["name"] = "Merge";
  Json dependency = Json::object();
  dependency["dependsOn"] = "Shards";
  merge["dependencies"] = Json::array({dependency});
  merge["script"] = step_script(std::move(merge_args));
  Json all = Json::object();
  all["specificationVersion"] = "jobtemplate-2023-09";
  all["name"] = plain_name(jobs.name);
  all["parameterDefinitions"] = Json::array({program});
  all["steps"] = Json::array({shards, merge});
  return all.dump(2) + "\n";
}

}  // namespace crowdbench::bench::sweep
