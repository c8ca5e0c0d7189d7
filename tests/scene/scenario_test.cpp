#include "scene/scenario/scenario.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/random.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_changes.h"
#include "scene/scenario/scenario_keys.h"
#include "scene/scenario/scenario_writer.h"
#include "test_paths.h"

namespace crowdbench::scene {
namespace {

std::string fault(const std::string& toml) {
  try {
    parse_scenario(toml, "s.toml");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Scenario, AnEmptyTextIsTheDefaults) {
  EXPECT_EQ(parse_scenario("", "s.toml"), Scenario{});
  EXPECT_EQ(parse_scenario("\n# nothing\n", "s.toml"), Scenario{});
}

TEST(Scenario, ReadsWhatItSays) {
  const Scenario s = parse_scenario(R"(
name = "street"
seed = 42
width = 1280
height = 720
occupancy = 0.15
background = '#ff0000'
[crowd]
agents = 1000
placement = "poisson"
heading_deg = 90
centre = [1e7, 2, -3.5]
[camera]
eye = [0, 4.0, 12]
fov_y_deg = 60
far = 100
[light]
ambient = 0.5
[[character]]
source = "a.glb"
height = "as_is"
clips = ["walk", "2"]
share = 3
[[character]]
)",
                                    "s.toml");
  EXPECT_EQ(s.name, "street");
  EXPECT_EQ(s.seed, 42U);
  EXPECT_EQ(s.width, 1280);
  EXPECT_EQ(s.height, 720);
  EXPECT_EQ(s.occupancy, 0.15);
  EXPECT_EQ(s.background, glm::vec3(1.0F, 0.0F, 0.0F));
  EXPECT_EQ(s.crowd.agents, 1000U);
  EXPECT_EQ(s.crowd.placement, PlacementKind::poisson);
  EXPECT_EQ(s.crowd.heading_deg, 90.0);
  EXPECT_EQ(s.crowd.centre, glm::dvec3(1e7, 2.0, -3.5));
  EXPECT_EQ(s.camera.keys.front().camera.eye, glm::dvec3(0.0, 4.0, 12.0));
  EXPECT_NEAR(s.camera.keys.front().camera.fov_y, 1.0471975511965976, 1e-15);
  EXPECT_EQ(s.camera.keys.front().camera.far, 100.0);
  EXPECT_EQ(s.light.ambient, 0.5F);
  ASSERT_EQ(s.characters.size(), 2U);
  EXPECT_EQ(s.characters[0].source, "a.glb");
  EXPECT_FALSE(s.characters[0].height.has_value());
  EXPECT_EQ(s.characters[0].clips, (std::vector<std::string>{"walk", "2"}));
  EXPECT_EQ(s.characters[0].share, 3.0);
  EXPECT_EQ(s.characters[1], CharacterEntry{});
}

TEST(Scenario, ReadsACameraPath) {
  const Scenario s =
      parse_scenario("[[camera.key]]\ntime = 0\neye = [1,2,3]\n[[camera.key]]\ntime = 2.5\neye = [4,5,6]\n", "s.toml");
  ASSERT_EQ(s.camera.keys.size(), 2U);
  EXPECT_EQ(s.camera.keys[1].time, 2.5);
  EXPECT_EQ(s.camera.keys[1].camera.eye, glm::dvec3(4, 5, 6));
  EXPECT_EQ(s.camera.at(1.25).eye, glm::dvec3(2.5, 3.5, 4.5));
}

TEST(Scenario, SeedsReachTheWholeRange) {
  EXPECT_EQ(parse_scenario("seed = 0", "s").seed, 0U);
  EXPECT_EQ(parse_scenario("seed = 9223372036854775807", "s").seed, 9223372036854775807U);
  EXPECT_EQ(parse_scenario("seed = \"18446744073709551615\"", "s").seed, 18446744073709551615U);
  EXPECT_NE(fault("seed = -1").find("s.toml:1: `seed` is -1"), std::string::npos);
  EXPECT_NE(fault("seed = \"18446744073709551616\"").find("0 to 18446744073709551615"), std::string::npos);
}

TEST(Scenario, EveryFaultNamesLineKeyAndCure) {
  EXPECT_EQ(fault("seed = 1\n[crowd]\nagnets = 3\n"), "s.toml:3: unknown key `crowd.agnets`; did you mean `agents`?");
  EXPECT_EQ(fault("[crowd]\n\nagents = \"many\"\n"), "s.toml:3: `crowd.agents` is a text; give an integer");
  EXPECT_EQ(fault("[crowd]\nagents = 1000001\n"),
            "s.toml:2: `crowd.agents` is 1000001; it must lie between 0 and 1000000");
  EXPECT_EQ(fault("[crowd]\nspacing = 0.1\n"), "s.toml:2: `crowd.spacing` is 0.1; it must lie between 0.7 and 100 m");
  EXPECT_EQ(fault("[crowd]\nspacing = nan\n"), "s.toml:2: `crowd.spacing` is nan; it must lie between 0.7 and 100 m");
  EXPECT_EQ(fault("[crowd]\nplacement = \"grit\"\n"),
            "s.toml:2: `crowd.placement` is `grit`, not one of grid, jittered, poisson, lanes; did you mean `grid`?");
  EXPECT_EQ(fault("background = \"grey\""), "s.toml:1: `background` is `grey`, not a colour; write it like '#808080'");
  EXPECT_EQ(fault("agents = 3"), "s.toml:1: unknown key `agents`; did you mean `crowd.agents`?");
  EXPECT_EQ(fault("[crowd]\nheading_deg = true"),
            "s.toml:2: `crowd.heading_deg` is a truth value; give a number or \"random\"");
  EXPECT_EQ(fault("[camera]\neye = [1, 2]"),
            "s.toml:2: `camera.eye` is a list; give three numbers like [0.0, 1.6, 5.0]");
  EXPECT_EQ(fault("\n[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]"),
            "s.toml:2: camera looks at its own place; move `eye` or `target`");
  EXPECT_EQ(fault("crowd = 3"), "s.toml:1: `crowd` is an integer; write it as a table: [crowd]");
  EXPECT_EQ(fault("[character]\nsource = \"a\""),
            "s.toml:1: `character` is a table; write each as a table of its own: [[character]]");
  EXPECT_NE(fault("[camera]\nfar = 10\n[[camera.key]]\ntime = 1").find("keep one of them"), std::string::npos);
  EXPECT_NE(fault("[camera]\nnear = 2\nfar = 1").find("far 1 before near 2"), std::string::npos);
  EXPECT_NE(fault("[[camera.key]]\ntime = 1\n[[camera.key]]\ntime = 1").find("order the keys by time"),
            std::string::npos);
  EXPECT_NE(fault("seed = \n").find("s.toml:1: "), std::string::npos);
  EXPECT_NE(fault("seed = 1\nseed = 2\n").find("s.toml:2: "), std::string::npos) << fault("seed = 1\nseed = 2\n");
  EXPECT_NE(fault("[crowd]\nmotion = \"lanes\"\nstage = \"frustum\"").find("stage = \"plaza\""), std::string::npos);
}

TEST(Scenario, FaultsAreOneLine) {
  for (const char* text : {"=", "a\nb", "[", "x = \"\\q\"", "x = 1e", "[[a]", "'", "\"\"\"", "a.b.c", "x = {a = }"}) {
    const std::string message = fault(text);
    EXPECT_NE(message, "accepted") << text;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(message.rfind("s.toml", 0), 0U) << message;
  }
}

TEST(Scenario, RefusesHostileText) {
  EXPECT_NE(fault("[\r-").find("control character 0x0d"), std::string::npos) << fault("[\r-");
  EXPECT_NE(fault("x = " + std::string(100'000, '[')).find("nest deeper"), std::string::npos);
  EXPECT_NE(fault("x = " + std::string(100'000, '{')).find("nest deeper"), std::string::npos);
  std::string dotted = "a";
  for (int i = 0; i < 50'000; ++i) dotted += ".a";
  EXPECT_NE(fault(dotted + " = 1").find("dots"), std::string::npos);
  EXPECT_NE(fault("name = \"\xff\"").find("not valid UTF-8"), std::string::npos);
  EXPECT_NE(fault("name = \"\xc0\x80\"").find("not valid UTF-8"), std::string::npos);
  EXPECT_NE(fault(std::string("name = \"a\0b\"", 12)).find("control character 0x00"), std::string::npos);
  EXPECT_NE(fault("name = \"a\\u0000b\"").find("zero byte"), std::string::npos);
  EXPECT_NE(fault(std::string(300'000, '#')).find("more than the limit"), std::string::npos);
  EXPECT_NE(fault("width = 99999999999999999999999999"), "accepted");
  EXPECT_NE(fault("tick_rate = 1e999"), "accepted");
  EXPECT_NE(fault("tick_rate = -inf"), "accepted");
  std::string wide = "name = [";
  for (int i = 0; i < 5000; ++i) wide += "1,";
  EXPECT_NE(fault(wide + "]").find("s.toml:1: is longer than 8192 bytes"), std::string::npos);
  // A bracket inside a text is none.
  EXPECT_EQ(parse_scenario("name = \"" + std::string(100, '[') + "\"", "s").name, std::string(100, '['));
}

TEST(Scenario, DefaultsSurviveTheRoundTrip) { EXPECT_EQ(parse_scenario(to_toml(Scenario{}), "s.toml"), Scenario{}); }

TEST(Scenario, LongTextsAndListsSurviveTheRoundTrip) {
  Scenario s;
  s.characters[0].clips.assign(60, std::string(700, '"') + std::string(324, '\x01'));
  s.name = std::string(1024, '\x1f');
  EXPECT_EQ(parse_scenario(to_toml(s), "s.toml"), s);
}

// A value of the key's range for each of a hundred seeds.
KeyValue random_value(const Key& key, uint64_t seed, uint64_t index) {
  const double u = random_unit(seed, index, 1);
  if (!key.absent.empty() && random_bits(seed, index, 2) % 4 == 0) return {};
  const auto text = [&](uint64_t purpose) {
    static const char* const all[] = {"a",         "with space",         "quote\"back\\slash",
                                      "tab\there", "gr\xc3\xbc\xc3\x9f", "[x]"};
    return std::string(all[random_below(seed, index, purpose, 6)]);
  };
  switch (key.type) {
    case KeyType::flag: return u < 0.5;
    case KeyType::integer:
      if (key.name == "samples") return int64_t{1} << random_below(seed, index, 3, 4);
      if (key.name == "supersample") return 1 + 2 * static_cast<int64_t>(random_below(seed, index, 3, 5));
      return static_cast<int64_t>(key.low) +
             static_cast<int64_t>(random_below(seed, index, 3, static_cast<uint64_t>(key.high - key.low) + 1));
    case KeyType::seed: return random_bits(seed, index, 4);
    case KeyType::number: {
      const double value = key.low + u * (key.high - key.low);
      return key.table == "light" ? std::stod(fmt::format("{}", static_cast<float>(value))) : value;
    }
    case KeyType::text: return text(5);
    case KeyType::choice: return static_cast<int64_t>(random_below(seed, index, 6, key.words.size()));
    case KeyType::colour: return fmt::format("#{:06x}", random_below(seed, index, 7, 1 << 24));
    case KeyType::vector: {
      glm::dvec3 v;
      for (int i = 0; i < 3; ++i) {
        v[i] = key.low + random_unit(seed, index, static_cast<uint64_t>(8 + i)) * (key.high - key.low);
        if (key.table == "light") v[i] = static_cast<float>(v[i]);
      }
      return v;
    }
    case KeyType::size: {
      const auto side = [&](uint64_t purpose) {
        return static_cast<int64_t>(1 + random_below(seed, index, purpose, static_cast<uint64_t>(key.high)));
      };
      return std::array{side(13), side(14)};
    }
    case KeyType::texts: {
      std::vector<std::string> texts;
      for (uint64_t i = 0; i < random_below(seed, index, 11, 4); ++i) texts.push_back(text(12 + i));
      return texts;
    }
  }
  return {};
}

TEST(Scenario, RandomScenariosSurviveTheRoundTrip) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    Scenario s;
    s.characters.resize(1 + seed % 3);
    s.camera.keys.resize(1 + seed % 4, s.camera.keys.front());
    uint64_t index = 0;
    for (const Key& key : scenario_keys()) {
      const bool path = s.camera.keys.size() > 1;
      if (key.table == (path ? "camera" : "camera.key")) continue;
      const size_t entries = key.table == "character"    ? s.characters.size()
                             : key.table == "camera.key" ? s.camera.keys.size()
                                                         : 1;
      for (size_t i = 0; i < entries; ++i) key.set(s, i, random_value(key, seed, index++));
    }
    // What keys must agree about.
    for (size_t i = 0; i < s.camera.keys.size(); ++i) {
      s.camera.keys[i].time = s.camera.keys.size() > 1 ? 0.1 * static_cast<double>(i) : 0.0;
      s.camera.keys[i].camera.far = s.camera.keys[i].camera.near * 2;
    }
    s.crowd.stage_far = s.crowd.stage_near + 1;
    if (s.crowd.motion == MotionKind::lanes) s.crowd.stage = Stage::plaza;
    const std::string text = to_toml(s);
    const Scenario back = parse_scenario(text, "s.toml");
    EXPECT_EQ(back, s) << text;
    EXPECT_EQ(to_toml(back), text);
  }
}

TEST(Scenario, ADisplayIsANameOrATable) {
  EXPECT_EQ(parse_scenario("display = 'standard_fhd'", "s.toml"),
            parse_scenario("[display]\nmodel = 'standard_fhd'", "s.toml"));
  KeyPlaces places;
  const Scenario s = parse_scenario("[display]\nresolution = [1920, 1080]\nE_ambient = 10\n", "s.toml", &places);
  EXPECT_EQ(s.display.resolution, (std::array<int64_t, 2>{1920, 1080}));
  EXPECT_EQ(s.display.e_ambient, 10);
  EXPECT_EQ(s.display.model, std::nullopt);
  EXPECT_EQ(places.at("display.E_ambient"), "s.toml:3");
  places.clear();
  parse_scenario("\ndisplay = 'a'", "s.toml", &places);
  EXPECT_EQ(places.at("display.model"), "s.toml:2");
  EXPECT_EQ(fault("[display]\nmax_luminence = 200"),
            "s.toml:2: unknown key `display.max_luminence`; did you mean `max_luminance`?");
  EXPECT_EQ(fault("[display]\nresolution = [1920]"),
            "s.toml:2: `display.resolution` is a list; give two integers like [1920, 1080] or \"none\"");
  EXPECT_EQ(fault("[display]\nresolution = [1920, 0]"),
            "s.toml:2: `display.resolution` is 0; it must lie between 1 and 65536 pixels");
  EXPECT_EQ(fault("display = 4"), "s.toml:1: `display` is an integer; write it as a table: [display]");
}

TEST(Scenario, EveryKeyIsInTheTextTheSchemaAndTheManual) {
  const auto schema = nlohmann::json::parse(scenario_schema());
  EXPECT_EQ(schema.at("$schema"), "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(schema.at("additionalProperties"), false);
  const std::string text = fmt::format("\n{}", to_toml(Scenario{}));
  const std::string manual = scenario_markdown();
  for (const Key& key : scenario_keys()) {
    SCOPED_TRACE(key.table + "." + key.name);
    const nlohmann::json* properties = &schema.at("properties");
    std::string rest = key.table;
    while (!rest.empty()) {
      const size_t dot = rest.find('.');
      const nlohmann::json& found = properties->at(rest.substr(0, dot));
      const nlohmann::json& inner = found.contains("anyOf") ? found.at("anyOf").at(0) : found;  // or a short form
      properties = inner.at("type") == "array" ? &inner.at("items").at("properties") : &inner.at("properties");
      rest = dot == std::string::npos ? "" : rest.substr(dot + 1);
    }
    const nlohmann::json& entry = properties->at(key.name);
    EXPECT_TRUE(entry.contains("default"));
    EXPECT_FALSE(entry.at("description").get<std::string>().empty());
    EXPECT_NE(manual.find(fmt::format("| `{}` |", key.name)), std::string::npos);
    if (key.table != "camera.key") {
      EXPECT_NE(text.find(fmt::format("\n{} = ", key.name)), std::string::npos);
    }
  }
}

TEST(Scenario, SchemaDefaultsAreTheStructs) {
  const auto schema = nlohmann::json::parse(scenario_schema());
  const auto& top = schema.at("properties");
  EXPECT_EQ(top.at("width").at("default"), Scenario{}.width);
  EXPECT_EQ(top.at("tick_rate").at("default"), Scenario{}.tick_rate);
  EXPECT_EQ(top.at("occupancy").at("default"), "none");
  EXPECT_EQ(top.at("background").at("default"), "#808080");
  const auto& crowd = top.at("crowd").at("properties");
  EXPECT_EQ(crowd.at("agents").at("default"), CrowdSettings{}.agents);
  EXPECT_EQ(crowd.at("spacing").at("default"), CrowdSettings{}.spacing);
  EXPECT_EQ(crowd.at("placement").at("default"), "jittered");
  EXPECT_EQ(crowd.at("placement").at("enum").size(), 4U);
  EXPECT_EQ(crowd.at("agents").at("maximum"), 1'000'000);
  EXPECT_EQ(top.at("camera").at("properties").at("fov_y_deg").at("default"), 35.0);
}

TEST(Scenario, EveryScenarioThatShipsIsRead) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CROWDBENCH_SOURCE_DIR "/bench/scenarios")) {
    const Scenario s = load_scenario(entry.path());
    EXPECT_EQ(s.name, entry.path().stem().string());
    ++count;
  }
  EXPECT_GE(count, 4);
}

TEST(Scenario, KeysHaveTheirUnitsInTheirNames) {
  for (const Key& key : scenario_keys()) {
    EXPECT_EQ(key.unit == "degrees", key.name.ends_with("_deg")) << key.name;
    EXPECT_FALSE(key.meaning.empty()) << key.name;
  }
}

// ---- scenarios within other documents

std::string fault_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ScenarioChanges, TouchNothingButTheirKeys) {
  Scenario scenario;
  scenario.seed = 9;
  KeyPlaces places;
  change_scenario(scenario, parse_toml("label = \"ten\"\ncrowd.agents = 10\n", "p.toml"), "p.toml", &places, "label");
  Scenario wanted;
  wanted.seed = 9;
  wanted.crowd.agents = 10;
  EXPECT_EQ(scenario, wanted);
  EXPECT_EQ(places, (KeyPlaces{{"crowd.agents", "p.toml:2"}}));
  change_scenario(scenario, TomlNode{}, "p.toml");
  EXPECT_EQ(scenario, wanted) << "an empty table";
  EXPECT_EQ(fault_of([&] { change_scenario(scenario, parse_toml("label = 1", "p.toml"), "p.toml"); }).substr(0, 30),
            "p.toml:1: unknown key `label`;")
      << "nobody said that it is to be passed over";
}

TEST(ScenarioChanges, OneValueIsReadAsItsKeysType) {
  const auto key = [](const char* table, const char* name) -> const Key& {
    return *std::ranges::find_if(scenario_keys(), [&](const Key& k) { return k.table == table && k.name == name; });
  };
  TomlNode seven;
  seven.type = TomlNode::Type::integer;
  seven.integer = 7;
  seven.line = 3;
  EXPECT_TRUE(read_key(key("crowd", "agents"), seven, "p.toml") == KeyValue(int64_t{7}));
  EXPECT_TRUE(read_key(key("crowd", "spacing"), seven, "p.toml") == KeyValue(7.0)) << "integers are taken as numbers";
  const std::string fault = fault_of([&] { (void)read_key(key("", "name"), seven, "p.toml"); });
  EXPECT_TRUE(fault.starts_with("p.toml:3: ")) << fault;
}

// What no single key can know, each at its limit and just beyond it.
TEST(ScenarioChanges, KeysThatDoNotGoTogetherAreRefusedWhereTheyWereGiven) {
  const auto fault_with = [](const std::function<void(Scenario&)>& change) {
    Scenario scenario;
    change(scenario);
    return fault_of([&] { check_scenario(scenario, [](const char* key) { return std::string("at ") + key; }); });
  };
  EXPECT_EQ(fault_with([](Scenario&) {}), "accepted");
  EXPECT_EQ(fault_with([](Scenario& s) { s.antialiasing.samples = 8; }), "accepted");
  EXPECT_TRUE(fault_with([](Scenario& s) { s.antialiasing.samples = 6; }).starts_with("at samples: `samples` is 6"));
  EXPECT_TRUE(fault_with([](Scenario& s) { s.antialiasing.supersample = 4; }).starts_with("at supersample: "));
  EXPECT_TRUE(fault_with([](Scenario& s) { s.light.direction = {}; }).starts_with("at light: "));
  EXPECT_EQ(fault_with([](Scenario& s) { s.crowd.stage_far = s.crowd.stage_near; }), "accepted");
  EXPECT_TRUE(fault_with([](Scenario& s) { s.crowd.stage_far = s.crowd.stage_near - 1; }).starts_with("at crowd: "));
  EXPECT_TRUE(fault_with([](Scenario& s) {
                s.camera.keys.push_back(s.camera.keys.front());
              }).starts_with("at camera: camera key 2 at 0 s does not follow"));
}

}  // namespace
}  // namespace crowdbench::scene
