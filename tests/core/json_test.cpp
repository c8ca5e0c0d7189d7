// Json against nlohmann-json, whose text it is to print.
#include "core/json.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace crowdbench {
namespace {

using Other = nlohmann::ordered_json;

// The same braces, as a value of either kind.
template <typename J>
J nested() {
  J json = {{"text", "a \"b\" \n"},
            {"truth", true},
            {"none", nullptr},
            {"nothing", {}},
            {"negative", -7},
            {"large", std::numeric_limits<uint64_t>::max()},
            {"least", std::numeric_limits<int64_t>::min()},
            {"third", 1.0 / 3},
            {"whole", 2.0},
            {"tiny", 5e-324},
            {"not_a_number", std::nan("")},
            {"single", 0.1F},
            {"pair", {1, 2}},
            {"texts", {"a", "b"}},
            {"members", {{"x", 1}, {"y", {{"z", 2}}}}},
            {"mixed", {{"x", 1}, 2}},
            {"rows", J::array({{{"a", 1}}, {{"a", 2}}})},
            {"names", std::vector<std::string>{"one", "two"}},
            {"triple", std::array<double, 3>{1, 0.5, 0.25}},
            {"empty_list", J::array()},
            {"empty_object", J::object()}};
  json["added"] = "later";
  json["text"] = std::string("changed, in its place");
  json["list"].push_back(1);
  json["list"].push_back({{"k", "v"}});
  json["deep"]["deeper"] = 1;
  json.update({{"pair", 3}, {"last", 4}});
  return json;
}

TEST(Json, PrintsWhatNlohmannPrints) {
  for (const int indent : {-1, 0, 2}) EXPECT_EQ(nested<Json>().dump(indent), nested<Other>().dump(indent)) << indent;
  EXPECT_EQ(Json().dump(), "null");
  EXPECT_EQ(Json({1, 2}).dump(), "[1,2]");
}

TEST(Json, KeepsTheOrderOfItsMembers) {
  Json json = {{"b", 1}, {"a", 2}};
  json["b"] = 3;
  EXPECT_EQ(json.dump(), R"({"b":3,"a":2})");
}

TEST(Json, BytesThatAreNotUtf8AreReplaced) { EXPECT_EQ(Json("a\xff").dump(), "\"a\xef\xbf\xbd\""); }

TEST(Json, CopiesAreApart) {
  Json first = {{"a", {1, 2}}};
  Json second = first;
  second["a"].push_back(3);
  first = first.at("a");  // from its own inside
  EXPECT_EQ(first.dump(), "[1,2]");
  EXPECT_EQ(second.dump(), R"({"a":[1,2,3]})");
}

TEST(Json, MembersStayWhereTheyAre) {
  Json json;
  Json& first = json["a"];
  for (const char* key : {"b", "c", "d", "e", "f", "g", "h", "i"}) json[key] = nullptr;
  json["j"] = first = Json::array();
  first.push_back(1);
  EXPECT_EQ(json.at("a").dump(), "[1]");
  EXPECT_EQ(json.at("j").dump(), "[]");
}

TEST(Json, GivesBackWhatItHolds) {
  const Json json = Json::parse(nested<Json>().dump());
  EXPECT_EQ(json.dump(), nested<Json>().dump());
  EXPECT_EQ(json.at("text").text(), "changed, in its place");
  EXPECT_TRUE(json.at("truth").truth());
  EXPECT_TRUE(json.at("none").is_null());
  EXPECT_EQ(json.at("negative").integer(), -7);
  EXPECT_EQ(json.at("negative").number(), -7);
  EXPECT_EQ(json.at("third").number(), 1.0 / 3);
  EXPECT_TRUE(json.at("large").is_number());
  EXPECT_TRUE(json.at("names").elements()[1].is_string());
  EXPECT_EQ(json.at("members").size(), 2U);
  EXPECT_TRUE(json.at("empty_list").empty());
}

}  // namespace
}  // namespace crowdbench
