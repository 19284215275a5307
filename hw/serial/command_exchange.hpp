// Sends a projector's commands one at a time and gives each its reply: a command is sent once the previous
// one was answered or given up. Light off goes ahead of all others: at once, or as soon as the table's gap
// has passed. At 9600 baud a command of 8 bytes takes 8 ms and so does its reply, and the projector needs
// time in between. Event loop's thread only; must not be destroyed from inside its own callbacks.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "hw/clock.hpp"
#include "hw/projector.hpp"
#include "hw/serial/byte_channel.hpp"
#include "hw/serial/projector_table.hpp"
#include "hw/serial/reply_reader.hpp"

namespace contourd {

class CommandExchange {
 public:
  using RequestId = ReplyReader::RequestId;

  struct Answer {
    ProjectorReply reply = ProjectorReply::Ok;
    ReplyMeaning meaning = ReplyMeaning::Accepted;
    std::optional<std::int64_t> value{};
    bool ambiguous = false;  // may be a repeated reply to an earlier command
    bool garbled = false;    // other bytes came that made no sense
    TimePoint begun{};       // when the request's turn came

    [[nodiscard]] bool says(ReplyMeaning said) const {
      return reply == ProjectorReply::Ok && meaning == said;
    }
  };
  // The treatment of an ambiguous reply, which may be another command's: the reply counts; or the command is
  // sent again until a reply is unambiguous; or is sent again after a reply to an earlier command, too.
  enum class Ambiguous { Counts, SendsAgain, SendsAgainAnyway };
  struct Request {
    const ProjectorCommand* command;  // must outlive the answer
    std::function<void(const Answer&)> done;
    int retries;         // after the first attempt
    bool stays = false;  // preempt() does not drop the request
    Ambiguous if_ambiguous = Ambiguous::Counts;
    RequestId id = 0;  // set by ask(), but by the caller of ask_first()
    int sent = 0;
    TimePoint begun{};
  };

  struct Listener {
    std::function<void(const ProjectorCommand&, TimePoint first_byte)> sent;
    std::function<void(const UnaskedLine&)> unasked;
    std::function<void(const std::string& why)> lost;
  };

  // All arguments must outlive the exchange; the table must not move.
  CommandExchange(ByteChannel& channel, Clock& clock, const ProjectorTable& table, Listener listener);
  ~CommandExchange() { channel_.listen({}); }
  CommandExchange(const CommandExchange&) = delete;
  CommandExchange& operator=(const CommandExchange&) = delete;

  // Queues a command with the table's retries.
  void ask(const ProjectorCommand& command, std::function<void(const Answer&)> done, bool stays = false);
  void ask(Request request);
  // Puts a request ahead of all others, in place of an earlier one that is pending there. Does nothing if the
  // command is the current one. Replies to earlier requests of the same id count too.
  void ask_first(Request request);
  [[nodiscard]] RequestId new_id() { return ++last_id_; }

  // Drops all requests except those that stay, which continue after the next ask_first(). A current light off
  // continues, and so does a current power off if `light_is_off`. Sends nothing: to be followed by
  // ask_first() or go_on().
  void preempt(bool light_is_off);
  // Drops the pending requests with this command.
  void drop(const ProjectorCommand& command) {
    std::erase_if(queue_, [&command](const Request& request) { return request.command == &command; });
  }
  void drop_first() { first_.reset(); }
  void go_on();

  [[nodiscard]] bool idle() const { return !current_ && !first_ && queue_.empty(); }
  // True if the line is lost for good.
  [[nodiscard]] bool lost() const { return lost_; }
  // Sends the bytes during the shutdown. Blocks.
  void write_and_wait(std::string_view bytes) { channel_.write_and_wait(bytes, table_.gap); }

  // "the projector at /dev/ttyUSB0"
  [[nodiscard]] std::string called() const { return "the projector at " + channel_.name(); }
  // Returns the last problem: a reply that was not Ok, in a sentence with the port and the bytes that came
  // back, or the text of the last note_problem().
  [[nodiscard]] const std::string& problem() const { return problem_; }
  void note_problem(std::string problem) { problem_ = std::move(problem); }

 private:
  void send();
  void hear(std::string_view bytes);
  void take(const ReplyReader::Heard& heard);
  void timed_out();
  void finish(Answer answer);
  void give_up();
  void lose(const std::string& why);
  [[nodiscard]] std::string no_answer(const Request& request) const;

  ByteChannel& channel_;
  Clock& clock_;
  const ProjectorTable& table_;
  Listener listener_;
  ReplyReader reader_;
  std::deque<Request> queue_;
  std::optional<Request> first_, current_;
  RequestId last_id_ = 0;
  TimePoint free_at_{};           // when the gap is over
  std::unique_ptr<Timer> timer_;  // for the current request: its gap, then its reply
  std::string problem_;
  bool lost_ = false;
};

}  // namespace contourd
