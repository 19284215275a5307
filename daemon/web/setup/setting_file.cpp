#include "daemon/web/setup/setting_file.hpp"

#include <fmt/format.h>

#include <system_error>

#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"

namespace contourd::web {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_to(std::string_view what, const fs::path& file, const std::error_code& why) {
  throw OutputError(fmt::format("cannot {} {}: {}; run the command as root", what, printable(file.string()),
                                why.message()));
}

}  // namespace

void write_setting(const fs::path& file, std::string_view text) {
  std::error_code ignored;  // without the folder, the file cannot be written
  fs::create_directories(file.parent_path(), ignored);
  try {
    NewFile written(file.parent_path());
    written.write(text);
    written.let_all_read();
    written.replace(file.filename().string());
  } catch (const std::system_error& failed) {
    fail_to("write", file, failed.code());
  }
}

void remove_setting(const fs::path& file) {
  std::error_code error;
  if (!fs::remove(file, error) && error) fail_to("remove", file, error);
}

}  // namespace contourd::web
