#include "daemon/ctl/setup/setup_record.hpp"

#include <nlohmann/json.hpp>
#include <optional>

#include "daemon/json/json_document.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd::ctl {
namespace {

constexpr const char* kChecks = "checks";

// Returns the value as a user would type it, or nullopt for a value that is no answer.
std::optional<std::string> word_of(const nlohmann::json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number()) return value.dump();
  if (value.is_string()) return value.get<std::string>();
  return std::nullopt;
}

void read_checks(JsonDocument& document, const nlohmann::json& checks, SetupRecord& record) {
  const std::string pointer = std::string("/") + kChecks;
  if (!checks.is_object()) return document.add_violation(pointer, "not an object");
  for (const auto& [name, outcome] : checks.items()) {
    if (outcome.is_string())
      record.checks[name] = outcome.get<std::string>();
    else
      document.add_violation(child_pointer(pointer, name), "not a text");
  }
}

}  // namespace

SetupRecord read_setup_record(const std::filesystem::path& file) {
  JsonDocument document = JsonDocument::from_file(file);
  SetupRecord record;
  const nlohmann::json all = document.value();
  if (!all.is_object()) {
    document.add_violation("", "not an object with answers");
    document.throw_if_violated();
  }
  for (const auto& [key, value] : all.items()) {
    const std::string pointer = child_pointer("", key);
    if (key == kChecks) {
      read_checks(document, value, record);
    } else if (find_question(key) == nullptr) {
      document.add_violation(pointer, "no question has this key; the keys are: " + question_keys());
    } else if (const auto word = word_of(value)) {
      record.answers[key] = *word;
    } else {
      document.add_violation(pointer, "not a text, a number, true or false");
    }
  }
  document.throw_if_violated();
  return record;
}

void write_setup_record(const std::filesystem::path& file, const SetupRecord& record) {
  nlohmann::ordered_json all = nlohmann::ordered_json::object();
  for (const auto& [key, answer] : record.answers)
    all[key] = answer;
  if (!record.checks.empty()) all[kChecks] = record.checks;
  using Handler = nlohmann::ordered_json::error_handler_t;
  write_durably(file, all.dump(2, ' ', false, Handler::replace) + "\n");
}

}  // namespace contourd::ctl
