// What a daemon must know again after a restart, a line each in a file of its state folder
// (state_folder.hpp):
//
//   plate-occupied   the plate holds a part: the job's name
//   queue-held       no job begins until the owner has spoken: why
//   ended-print      how the print of the job in printing/ ended, until that is filed
//   queue-order      the names of the waiting jobs whose owner has changed their order, as files in
//   incoming/;
//                    each ended by a zero byte in the place of a line's end
//   accepted         what owners have accepted: contents and a finding, a line each (acceptances.hpp)
//
// What is set is on the disk before the call returns; what is there already is not written again. Thread-safe
// for different records (no shared state). All but what reads throws std::system_error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace contourd {

class StateRecords {
 public:
  explicit StateRecords(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // The job whose part is on the plate; nothing when the plate is clear.
  [[nodiscard]] std::optional<std::string> plate_occupant() const;
  void set_plate_occupant(const std::optional<std::string>& job) const;

  // Why no job is to begin until the owner has spoken, or nothing.
  [[nodiscard]] std::optional<std::string> hold() const;
  void set_hold(const std::optional<std::string>& why) const;

  // How the print of the job in printing/ ended, as the archivist has it; empty when nobody has told.
  [[nodiscard]] std::string end_of_print() const;
  void keep_end_of_print(const std::string& text) const;
  // Another job may get this one's name.
  void forget_end_of_print() const;

  // The next job first; empty where the order is that of their arrival.
  [[nodiscard]] std::vector<std::string> queue_order() const;
  void keep_queue_order(const std::vector<std::string>& files) const;

  [[nodiscard]] std::vector<std::string> accepted() const;
  void keep_accepted(const std::vector<std::string>& lines) const;

 private:
  [[nodiscard]] std::optional<std::string> first_line_of(const char* file) const;
  void keep_line(const char* file, const std::optional<std::string>& line) const;
  [[nodiscard]] std::vector<std::string> texts_of(const char* file, char end) const;
  void keep_texts(const char* file, const std::vector<std::string>& texts, char end) const;

  std::filesystem::path folder_;
};

}  // namespace contourd
