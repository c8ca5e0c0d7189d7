// A plan's shards as jobs of others' schedulers: a shard is one call of `crowdbench sweep --shard I/K`, and when all
// have ended one call of `crowdbench merge` puts them together (or says which are missing).
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace crowdbench::bench::sweep {

struct ShardJobs {
  std::string name;               // of the job
  std::filesystem::path program;  // absolute, here and below: jobs begin in folders of their own
  std::filesystem::path plan;
  std::filesystem::path out;  // the merged file; shards are beside it
  uint32_t shards = 1;
  std::vector<std::string> options = {};  // of each shard's `sweep`: "--device", "0"
};

// "textures.sqlite" to "textures-2-of-8.sqlite".
std::filesystem::path shard_file(const std::filesystem::path& out, uint32_t shard, uint32_t shards);

// Slurm: a job array of the shards, each alone on its node, which queues itself again where the shard ends with 75;
// and the merge.
std::string slurm_array(const ShardJobs& jobs);
std::string slurm_merge(const ShardJobs& jobs);
// Hands both scripts to sbatch, the merge to begin when every task has ended. Returns the jobs' numbers, "12, 13".
// Throws Error where sbatch fails, with what it said.
std::string submit(const std::filesystem::path& array, const std::filesystem::path& merge);

// Open Job Description, "jobtemplate-2023-09", as JSON: a step with a task a shard, a step for the merge that depends
// on it. Based on: the specification's wiki, "2023-09 Template Schemas".
std::string openjd_template(const ShardJobs& jobs);

}  // namespace crowdbench::bench::sweep
