// Keeps the history's database in a file, whatever becomes of that file: one that is damaged is put aside and
// begun anew, what cannot be written now is tried again, and what cannot be done at all is said. Blocks; one
// thread at a time, a worker's.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/history/history_database.hpp"

namespace contourd {

class HistoryStore {
 public:
  using Call = std::function<void(HistoryDatabase&)>;
  // Of changes that cannot be made yet, so many wait; of more the oldest are lost.
  static constexpr std::size_t kMostWaiting = 1'000;

  // Opens nothing yet.
  explicit HistoryStore(std::filesystem::path file) : file_(std::move(file)) {}

  // Makes the change, behind those that wait; or lets it wait. `change` must do no harm a second time.
  void change(Call change);
  // The same, but it does not wait when it cannot be made now.
  void change_now_or_never(const Call& change);
  // Behind the changes that wait. Throws std::runtime_error, a sentence.
  void ask(const Call& question);
  // Makes the changes that wait, as far as that is possible.
  void retry();

  [[nodiscard]] bool waits() const { return !waiting_.empty(); }
  // Why nothing can be written, a sentence; empty when the last change was made.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  // What became of a damaged file, a sentence each, since the last call.
  [[nodiscard]] std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

 private:
  // Does `call`, once more on a new file when this one is damaged. Throws std::runtime_error.
  void with_database(const Call& call);
  void open();
  void make_waiting_changes(HistoryDatabase& database);
  void put_aside(const std::string& why);

  std::filesystem::path file_;
  std::unique_ptr<HistoryDatabase> database_;
  ino_t inode_ = 0;  // of the file that is open
  std::deque<Call> waiting_;
  std::string trouble_;
  std::vector<std::string> notes_;
};

}  // namespace contourd
