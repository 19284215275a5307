// Runs the official tests of JSON Schema draft 7 from Debian's package json-schema-test-suite.

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "daemon/json/json_schema.hpp"
#include "daemon/json/schema_check.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kSuite = "/usr/share/json-schema-test-suite/tests/draft7";

// The only groups that may be skipped although all their keywords are supported.
const std::set<std::string> kGaps{
    // Lists of schemas, one for each element.
    "additionalItems.json: additionalItems are allowed by default",
    "items.json: an array of schemas for items",
    "items.json: items with boolean schemas",
    "ref.json: relative pointer ref to array",
    // Schemas on other machines, and "$id" within schemas.
    "definitions.json: invalid definition",
    "definitions.json: valid definition",
    "ref.json: Recursive references between schemas",
    "ref.json: remote ref, containing refs itself",
    "refRemote.json: base URI change",
    "refRemote.json: base URI change - change folder",
    "refRemote.json: base URI change - change folder in subschema",
    "refRemote.json: fragment within remote ref",
    "refRemote.json: ref within remote ref",
    "refRemote.json: remote ref",
    "refRemote.json: root ref in remote ref",
};

// The files of the suite that must be run: those of the supported keywords.
constexpr std::array kKeywords{"additionalProperties",
                               "enum",
                               "items",
                               "maxItems",
                               "maxLength",
                               "maximum",
                               "minItems",
                               "minLength",
                               "minimum",
                               "oneOf",
                               "pattern",
                               "properties",
                               "ref",
                               "required",
                               "type",
                               "default",
                               "boolean_schema"};

struct Tally {
  int groups = 0, cases = 0, groups_left_out = 0, cases_left_out = 0;
  std::map<std::string, std::vector<std::string>> left_out;  // groups by reason
  std::set<std::string> gaps, files_run;
};

bool fits(const JsonSchema& schema, const json& value) {
  JsonDocument document = JsonDocument::from_text("{}", "test.json");
  document.value() = value;
  check_by_schema(schema.root(), document);
  return document.violations().empty();
}

void leave_out(const std::string& name, const json& group, const ConfigError& error, Tally& tally) {
  const std::string reason = error.violations()[0].message;
  tally.groups_left_out += 1;
  tally.cases_left_out += static_cast<int>(group["tests"].size());
  tally.left_out[reason].push_back(name);
  if (!reason.starts_with("the keyword ")) tally.gaps.insert(name);
}

void run_group(const std::string& file, const json& group, Tally& tally) {
  const std::string name = file + ": " + group["description"].get<std::string>();
  tally.groups += 1;
  tally.cases += static_cast<int>(group["tests"].size());
  try {
    const JsonSchema schema(group["schema"].dump(), file);
    for (const json& test : group["tests"]) {
      INFO(name << ": " << test["description"].get<std::string>() << ": " << test["data"].dump());
      CHECK(fits(schema, test["data"]) == test["valid"].get<bool>());
    }
    tally.files_run.insert(file);
  } catch (const ConfigError& error) {
    leave_out(name, group, error, tally);
  }
}

std::vector<fs::path> suite_files() {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kSuite))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

void print(const Tally& tally) {
  std::printf("JSON Schema's official tests, draft 7: %d of %d groups, %d of %d cases were run.\n",
              tally.groups - tally.groups_left_out, tally.groups, tally.cases - tally.cases_left_out,
              tally.cases);
  for (const auto& [reason, groups] : tally.left_out) {
    std::printf("Left out, since %s: %zu groups\n", reason.c_str(), groups.size());
    for (const std::string& group : groups)
      std::printf("  %s\n", group.c_str());
  }
}

TEST_CASE("the official tests of every supported keyword pass", "[schema-suite]") {
  if (!fs::exists(kSuite)) {
    std::printf("SKIPPED: %s is not there: install json-schema-test-suite\n", kSuite.c_str());
    return;
  }
  Tally tally;
  for (const fs::path& path : suite_files()) {
    std::ifstream stream(path);
    for (const json& group : json::parse(stream))
      run_group(path.lexically_relative(kSuite).string(), group, tally);
  }
  print(tally);
  CHECK(tally.gaps == kGaps);
  for (const std::string keyword : kKeywords)
    CHECK(tally.files_run.contains(keyword + ".json"));
}

}  // namespace
}  // namespace contourd
