// The files that a scenario's characters are made of, as one fingerprint: a sweep must not take a point for done whose
// character has changed since.
#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "scene/scenario/scenario.h"

namespace crowdbench::bench::sweep {

// Hashes each file once however many scenarios name it.
class CharacterFiles {
 public:
  // folder: that the scenario's paths are relative to.
  explicit CharacterFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  // Of the contents of every character's file and its files of animations, and of the buffers and pictures that a glTF
  // file (.gltf or .glb) names in its folder; a file that cannot be read counts as missing. Empty where all characters
  // are built in.
  std::string fingerprint(const scene::Scenario& scenario);

 private:
  const std::string& hash(const std::string& source);

  std::filesystem::path folder_;
  std::map<std::string, std::string> known_;
};

}  // namespace crowdbench::bench::sweep
