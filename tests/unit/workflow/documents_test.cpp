#include "workflow/documents.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "base/file.hpp"
#include "workflow/keys.hpp"
#include "workflow/yaml.hpp"

namespace sandglass::workflow {
namespace {

using testing::HasSubstr;

const std::string folder = std::string(SANDGLASS_SOURCE_DIR) + "/workflows/";

/// With SANDGLASS_WRITE_DOCUMENTS set, the file is made anew instead of compared.
void expect_file(const std::string& name, const std::string& wanted) {
  if (std::getenv("SANDGLASS_WRITE_DOCUMENTS")) write_file(folder + name, wanted);
  EXPECT_EQ(read_file(folder + name), wanted)
      << "workflows/" << name
      << " and the table of keys have drifted apart; run this test once with "
      << "SANDGLASS_WRITE_DOCUMENTS=1";
}

TEST(Documents, TheSchemaInTheRepositoryIsThatOfTheTable) {
  expect_file("schema.json", json_schema());
}

TEST(Documents, TheReferenceInTheRepositoryIsThatOfTheTable) {
  expect_file("README.md", with_reference_page(read_file(folder + "README.md")));
}

TEST(Documents, EveryKeyIsExplainedInBoth) {
  const std::string page = reference_page();
  const auto schema = nlohmann::json::parse(json_schema());
  for (const Object& table : objects()) {
    const auto& place = &table == &objects().front() ? schema : schema["$defs"][table.name];
    for (const Key& key : table.keys) {
      EXPECT_FALSE(key.doc.empty()) << table.name << " " << key.name;
      EXPECT_FALSE(key.example.empty()) << table.name << " " << key.name;
      EXPECT_THAT(page, HasSubstr("| `" + key.name + "` |"));
      ASSERT_TRUE(place["properties"].contains(key.name)) << table.name << " " << key.name;
      EXPECT_EQ(place["properties"][key.name]["description"], key.doc);
    }
  }
}

TEST(Documents, EveryReferenceInTheSchemaLeadsSomewhere) {
  const auto schema = nlohmann::json::parse(json_schema());
  const auto flat = schema.flatten();
  int found = 0;
  for (const auto& [path, value] : flat.items()) {
    if (!path.ends_with("/$ref")) continue;
    ++found;
    EXPECT_TRUE(schema.contains(nlohmann::json::json_pointer(value.get<std::string>().substr(1))))
        << value;
  }
  EXPECT_GT(found, 10);
}

TEST(Documents, WithoutMarkersTheReadmeIsRefused) {
  EXPECT_THROW((void)with_reference_page("# Workflows\n"), std::invalid_argument);
}

}  // namespace
}  // namespace sandglass::workflow
