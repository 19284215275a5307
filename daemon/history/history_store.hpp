// Keeps the history's database in a file and handles that file's failures: a damaged file is renamed and a
// new one begins, changes that cannot be written are retried, and other errors are reported. Blocks; one
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
  // Maximum number of changes that wait until they can be made; of more, the oldest are lost.
  static constexpr std::size_t kMostWaiting = 1'000;

  // Does not open the file yet.
  explicit HistoryStore(std::filesystem::path file) : file_(std::move(file)) {}

  // Makes the waiting changes and then this one, or lets it wait. A second call of `change` must have no
  // effect.
  void change(Call change);
  // Makes the waiting changes and then this one; drops this one if it cannot be made now.
  void change_now_or_never(const Call& change);
  // Asks the question after the waiting changes. Throws std::runtime_error with a sentence.
  void ask(const Call& question);
  // Makes the waiting changes as far as possible.
  void retry();

  [[nodiscard]] bool waits() const { return !waiting_.empty(); }
  // Returns why changes cannot be written, a sentence; empty if the last one was.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  // Returns a sentence for each damaged file that was renamed since the last call.
  [[nodiscard]] std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

 private:
  // Makes the waiting changes and `call`, on a new file if this one is damaged. Throws std::runtime_error.
  void with_database(const Call& call);
  void open();
  void make_waiting_changes(HistoryDatabase& database);
  void put_aside(const std::string& why);

  std::filesystem::path file_;
  std::unique_ptr<HistoryDatabase> database_;
  ino_t inode_ = 0;  // the inode of the open file
  std::deque<Call> waiting_;
  std::string trouble_;
  std::vector<std::string> notes_;
};

}  // namespace contourd
