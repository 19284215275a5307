// Assembles the bytes that a projector sends into replies, and assigns each reply to its request. Removes
// echoes. The portions in which the bytes come make no difference. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hw/serial/projector_table.hpp"

namespace contourd {

class ReplyReader {
 public:
  using RequestId = std::uint64_t;

  struct Reply {
    RequestId request;
    ReplyMeaning meaning;
    std::optional<std::int64_t> value;
    std::string text;  // the line, or the bytes it ended in, as received
    // True if this may be another request's reply: one that was unanswered when the command was sent, had
    // been sent more than once, or had an ambiguous reply itself.
    bool ambiguous = false;
  };
  struct Heard {  // at most one of the two is set
    std::optional<Reply> reply;
    const UnaskedLine* unasked = nullptr;
  };

  // The table must outlive the reader and stay where it is.
  explicit ReplyReader(const ProjectorTable& table) : table_(table) {}

  // Expects a reply to a command that will have left by `sent`: it may come up to `patience` after that, or
  // after the previous reply. Projectors answer in the order of the commands, so a reply belongs to the
  // oldest command that it fits, and older commands have gone unanswered. Bytes that had begun to come before
  // this call are not a reply to this command. The command must outlive its reply.
  void expect(RequestId request, const ProjectorCommand& command, TimePoint sent, Duration patience);

  [[nodiscard]] Heard take(char byte, TimePoint now);
  // Ends the current line, because no more bytes have come for a while.
  [[nodiscard]] Heard end_line(TimePoint now);

  // Returns the bytes that came since forget() and made no sense, at most the last 64.
  [[nodiscard]] const std::string& unexplained() const { return unexplained_; }
  void forget() { unexplained_.clear(); }

 private:
  struct Owed {
    RequestId request;
    const ProjectorCommand* command;
    std::string bytes;    // as sent; empty once its echo has come
    std::uint64_t heard;  // number of bytes heard before it was sent
    Duration patience;
    std::vector<const ProjectorCommand*> before;  // other requests' commands, unanswered when it was sent
    TimePoint until;
    bool repeated = false;  // the request was sent more than once
  };
  // A request that was sent more than once, or got an ambiguous reply: another reply may follow.
  struct Repeat {
    RequestId request;
    const ProjectorCommand* command;
    TimePoint until;
  };

  [[nodiscard]] bool is_echo(bool of_line);
  [[nodiscard]] std::optional<ReplyPattern::Match> match(const Owed& owed, const ReplyPattern& pattern,
                                                         bool line, std::string_view text) const;
  [[nodiscard]] std::optional<Reply> match(bool line, std::string_view text, TimePoint now);
  void give_up(TimePoint now);
  [[nodiscard]] Heard explained(Heard heard);

  const ProjectorTable& table_;
  std::vector<Owed> owed_;  // oldest first
  std::vector<Repeat> repeats_;
  std::uint64_t heard_ = 0;       // number of bytes
  std::uint64_t line_begin_ = 0;  // number of bytes before the line's first non-blank byte
  std::string line_;              // since the last line end
  std::string received_;          // since the last reply, the last 64 bytes
  std::string unexplained_;
};

}  // namespace contourd
