// Makes replies of the bytes that a projector sends, and tells whose they are. Takes echoes out. How the
// bytes are portioned makes no difference. Not thread-safe.
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
    // Another request was unanswered when the command was sent, had been sent more than once, or had a
    // ambiguous reply itself: this may be its reply.
    bool ambiguous = false;
  };
  struct Heard {  // one or neither
    std::optional<Reply> reply;
    const UnaskedLine* unasked = nullptr;
  };

  // The table must outlive the reader and stay where it is.
  explicit ReplyReader(const ProjectorTable& table) : table_(table) {}

  // The command will have left by `sent`: a reply to it may come up to `patience` after that, or after the
  // reply before it. Projectors answer in the order of the commands, so that a reply belongs to the oldest
  // command that it fits, and commands before that one have gone unanswered. What had begun to come before
  // this call is no reply to it. The command must outlive that time.
  void expect(RequestId request, const ProjectorCommand& command, TimePoint sent, Duration patience);

  [[nodiscard]] Heard take(char byte, TimePoint now);
  // Nothing more has come for a while: what there is of a line is all of it.
  [[nodiscard]] Heard end_line(TimePoint now);

  // What came since forget() and made no sense, the last 64 bytes of it.
  [[nodiscard]] const std::string& unexplained() const { return unexplained_; }
  void forget() { unexplained_.clear(); }

 private:
  struct Owed {
    RequestId request;
    const ProjectorCommand* command;
    std::string bytes;    // as sent; empty once its echo has come
    std::uint64_t heard;  // bytes, before it was sent
    Duration patience;
    std::vector<const ProjectorCommand*> before;  // of other requests, unanswered when it was sent
    TimePoint until;
    bool repeated = false;  // the request was sent more than once
  };
  // A reply to a request that was sent more than once, or an ambiguous one: another may follow.
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
  std::uint64_t heard_ = 0;       // bytes
  std::uint64_t line_begin_ = 0;  // of these, before the line's first that is no blank
  std::string line_;              // since the last line end
  std::string received_;          // since the last reply, the last 64 bytes
  std::string unexplained_;
};

}  // namespace contourd
