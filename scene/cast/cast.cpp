#include "scene/cast/cast.h"

#include "scene/cast/open_character.h"

namespace crowdbench::scene {

Cast load_cast(const Scenario& scenario, const std::filesystem::path& folder) {
  Cast cast;
  double sum = 0;
  for (const CharacterEntry& entry : scenario.characters) sum += entry.share;
  for (const CharacterEntry& entry : scenario.characters) {
    LoadOptions options;
    options.normalise.height = entry.height;
    options.rigid_meshes = entry.rigid_meshes;
    options.hide = entry.hide;
    const bool built_in = entry.source == "mannequin" || entry.source.rfind("mannequin:", 0) == 0;
    const std::string source = built_in || folder.empty() ? entry.source : (folder / entry.source).string();
    auto character = std::make_shared<const Character>(open_character(source, options));
    std::vector<int> clips;
    for (const std::string& name : entry.clips) clips.push_back(require_clip(*character, name));
    if (clips.empty()) clips.push_back(character->placement.default_clip);
    cast.banks.push_back(std::make_shared<const PoseBank>(*character, clips, scenario.pose_rate));
    cast.characters.push_back(std::move(character));
    cast.shares.push_back(entry.share / sum);
  }
  return cast;
}

}  // namespace crowdbench::scene
