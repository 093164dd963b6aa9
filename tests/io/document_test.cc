// Documents as JSON: what stands in them, and what is read of JSON that others wrote.

#include "armtrue/io/document.h"

#include <gmock/gmock.h>

#include "armtrue/io/robot_io.h"
#include "armtrue/text/input_error.h"
#include "io/yaml/json_text.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {
namespace {

using testing::HasSubstr;

std::string json_of(const YAML::Node& value) {
  YAML::Node root;
  root["key"] = value;
  return print_document(flow(root)).json();
}

TEST(Document, JsonHasNumbersTruthValuesNullsAndTextsAsTheyAre) {
  EXPECT_EQ(json_of(YAML::Node(number_text(1e-5))), "{\"key\": 1.0e-05}\n");
  EXPECT_EQ(json_of(YAML::Node(number_text(-0.1))), "{\"key\": -0.1}\n");
  EXPECT_EQ(json_of(boolean(true)), "{\"key\": true}\n");
  EXPECT_EQ(json_of(rounded_or_null(std::nullopt)), "{\"key\": null}\n");
  EXPECT_EQ(json_of(rounded_or_null(INFINITY)), "{\"key\": null}\n");
  for (const char* text : {"0032", "true", "null", "1e3", "2026-11-27", ""})
    EXPECT_EQ(json_of(YAML::Node(std::string(text))), std::string("{\"key\": \"") + text + "\"}\n");
}

TEST(Document, GivesTheValueAtAPath) {
  YAML::Node root;
  root["errors"]["mean_mm"] = rounded(0.12344);
  root["notes"] = texts_node({"first", "second"});
  root["unknown"] = rounded_or_null(std::nullopt);
  const Document document = print_document(root);
  const auto value = [&](const char* path) {
    const std::string* const found = document.value(path);
    return found ? *found : "none";
  };
  EXPECT_EQ(value("errors/mean_mm"), "0.1234");
  EXPECT_EQ(value("notes/1"), "second");
  for (const char* path : {"errors", "notes/2", "unknown", "errors/mean_mm/0", ""})
    EXPECT_EQ(value(path), "none") << path;
}

TEST(Document, JsonEscapesWhatItMustNotHold) {
  EXPECT_EQ(json_of(YAML::Node("a \"b\" \\ c\nd\te")),
            "{\"key\": \"a \\\"b\\\" \\\\ c\\u000ad\\u0009e\"}\n");
  EXPECT_EQ(json_of(YAML::Node("\x7F\xE2\x80\xA8")), "{\"key\": \"\\u007f\\u2028\"}\n");
  EXPECT_EQ(json_of(YAML::Node("Gl\xC3\xBC\xF0\x9F\xA6\xBE")),
            "{\"key\": \"Gl\xC3\xBC\xF0\x9F\xA6\xBE\"}\n");
}

TEST(Document, JsonHasALineForEachKeyAndListsAsYamlHasThem) {
  YAML::Node root;
  root["b"].push_back(number_text(1));
  root["a"] = flow_list({1, 2.5});
  root["nothing"] = list_node({});
  root["map"] = YAML::Node(YAML::NodeType::Map);
  EXPECT_EQ(
      print_document(root).json(),
      "{\n  \"b\": [\n    1\n  ],\n  \"a\": [1, 2.5],\n  \"nothing\": [],\n  \"map\": {}\n}\n");
}

TEST(Document, CharactersInTwoHalvesBecomeWhole) {
  const std::string arm = "\xF0\x9F\xA6\xBE";
  EXPECT_EQ(with_whole_characters("{\"a\": \"\\ud83e\\uddbe\"}"), "{\"a\": \"" + arm + "\"}");
  EXPECT_EQ(with_whole_characters("\n{\"a\": \"x\\\\\\uD83E\\uDDBE\"}"),
            "\n{\"a\": \"x\\\\" + arm + "\"}");
  for (const char* same :
       {"{\"a\": \"\\\\ud83e\\\\uddbe\"}", "{\"a\": \"\\ud83e\"}", "{\"a\": \"\\ud83e\\u0041\"}",
        "{\"a\": \"\\\"", "{\"a\": \"\\", "a: \"\\ud83e\\uddbe\""})
    EXPECT_EQ(with_whole_characters(same), same);
}

TEST(Document, HalfACharacterIsAnErrorWithItsLine) {
  try {
    parse_robot("{\"format\": \"armtrue-robot/1\",\n\"name\": \"\\ud83e\"}", "r.json");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("r.json:2"));
  }
}

TEST(Document, AFileIsJsonByItsEnding) {
  for (const char* name : {"a.json", "folder.yaml/A.JSON", "loop.yaml.json"})
    EXPECT_TRUE(is_json_file(name)) << name;
  for (const char* name : {"", "-", "json", "a.json/b", "a.jsonl", "a.yaml", ".json"})
    EXPECT_FALSE(is_json_file(name)) << name;
}

}  // namespace
}  // namespace armtrue
