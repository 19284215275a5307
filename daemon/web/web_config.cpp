#include "daemon/web/web_config.hpp"

#include <algorithm>

#include "daemon/json/json_document.hpp"
#include "daemon/json/json_schema.hpp"
#include "daemon/json/json_section.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/web/web_texts.hpp"

namespace contourd::web {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kBytesOfMebibyte = std::uint64_t{1} << 20U;

JsonDocument document_of(const fs::path& file) {
  std::error_code ignored;
  if (file == kDefaultWebConfig && !fs::exists(file, ignored))
    return JsonDocument::from_text("{}", file.string());
  return JsonDocument::from_file(file);
}

}  // namespace

WebConfig load_web_config(const fs::path& file) {
  JsonDocument document = document_of(file);
  JsonSchema(web_schema_text, "web.schema.json").check(document);
  document.throw_if_violated();
  const JsonSection section(document);
  WebConfig config{
      .control_socket = resolved(folder_of(file), section.text("control_socket")),
      .names = section.texts("names"),
      .session = std::chrono::hours(section.integer<int>("session_hours")),
      .largest_upload_bytes = section.integer<std::uint64_t>("largest_upload_mb") * kBytesOfMebibyte,
      .min_free_disk_bytes = section.integer<std::uint64_t>("min_free_disk_mb") * kBytesOfMebibyte};
  for (std::string& name : config.names)
    std::ranges::transform(name, name.begin(), [](char letter) {
      return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
    });
  return config;
}

}  // namespace contourd::web
