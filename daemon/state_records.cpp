#include "daemon/state_records.hpp"

#include <fstream>
#include <system_error>

#include "daemon/durable_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOccupied = "plate-occupied";
constexpr const char* kHeld = "queue-held";
constexpr const char* kEnded = "ended-print";
constexpr const char* kOrder = "queue-order";

}  // namespace

std::optional<std::string> StateRecords::first_line_of(const char* name) const {
  std::ifstream file(folder_ / name);
  if (!file) return std::nullopt;
  std::string line;
  std::getline(file, line);
  return line;
}

void StateRecords::keep_line(const char* name, const std::optional<std::string>& line) const {
  if (first_line_of(name) == line) return;
  if (line) {
    write_durably(folder_ / name, *line + "\n");
  } else {
    fs::remove(folder_ / name);
    sync_folder(folder_);
  }
}

std::optional<std::string> StateRecords::plate_occupant() const {
  return first_line_of(kOccupied);
}
void StateRecords::set_plate_occupant(const std::optional<std::string>& job) const {
  keep_line(kOccupied, job);
}

std::optional<std::string> StateRecords::hold() const {
  return first_line_of(kHeld);
}
void StateRecords::set_hold(const std::optional<std::string>& why) const {
  keep_line(kHeld, why);
}

std::string StateRecords::end_of_print() const {
  return first_line_of(kEnded).value_or("");
}
void StateRecords::keep_end_of_print(const std::string& text) const {
  keep_line(kEnded, text);
}
void StateRecords::forget_end_of_print() const {
  std::error_code ignored;
  if (fs::remove(folder_ / kEnded, ignored)) sync_folder(folder_);
}

std::vector<std::string> StateRecords::queue_order() const {
  std::vector<std::string> files;
  std::ifstream file(folder_ / kOrder);
  // A last name without its end was not written whole: none is.
  for (std::string name; std::getline(file, name, '\0') && !file.eof();)
    files.push_back(name);
  return files;
}
void StateRecords::keep_queue_order(const std::vector<std::string>& files) const {
  if (files.empty()) {
    if (fs::remove(folder_ / kOrder)) sync_folder(folder_);
    return;
  }
  std::string text;
  for (const std::string& name : files)
    text.append(name).push_back('\0');
  write_durably(folder_ / kOrder, text);
}

}  // namespace contourd
