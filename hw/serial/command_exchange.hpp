// Sends a projector's commands one at a time and gives each its reply: the next when the one before was
// answered or given up. Light off goes ahead of all others: at once, or as soon as the table's gap has
// passed. At 9600 baud a command of 8 bytes takes 8 ms and so does its reply, and the projector thinks in
// between. Event loop's thread only; must not be destroyed from inside its own callbacks.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

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
    bool ambiguous = false;  // it may be an earlier command's reply once more
    bool garbled = false;    // what else came made no sense
    TimePoint begun{};       // its turn came
  };
  // What follows an ambiguous reply, one that may be another command's: it counts; or the command is sent
  // again until a reply is unambiguous; or also after a reply to an earlier command.
  enum class Ambiguous { Counts, SendsAgain, SendsAgainAnyway };
  struct Request {
    const ProjectorCommand* command;  // it must outlive the answer
    std::function<void(const Answer&)> done;
    int retries;         // after the first time
    bool stays = false;  // preempt() does not drop it
    Ambiguous if_ambiguous = Ambiguous::Counts;
    RequestId id = 0;  // given here, but for ask_first()
    int sent = 0;
    TimePoint begun{};
  };

  struct Listener {
    std::function<void(const ProjectorCommand&, TimePoint first_byte)> sent;
    std::function<void(const UnaskedLine&)> unasked;
    std::function<void(const std::string& why)> lost;
  };

  // All must outlive the exchange; the table stays where it is.
  CommandExchange(ByteChannel& channel, Clock& clock, const ProjectorTable& table, Listener listener);
  ~CommandExchange() { channel_.listen({}); }
  CommandExchange(const CommandExchange&) = delete;
  CommandExchange& operator=(const CommandExchange&) = delete;

  // With the table's retries.
  void ask(const ProjectorCommand& command, std::function<void(const Answer&)> done, bool stays = false);
  void ask(Request request);
  // Ahead of all others. One that is asked already goes on, one that waits so gives way. Replies to requests
  // of that id count too.
  void ask_first(Request request);
  [[nodiscard]] RequestId new_id() { return ++last_id_; }

  // Drops the requests that wait, except those that stay: they go on behind what comes first. A light off
  // that is asked goes on; so does a power off, if `light_is_off`. Sends nothing: to be followed by
  // ask_first() or go_on().
  void preempt(bool light_is_off);
  // Drops requests that wait.
  void drop(const ProjectorCommand& command);
  void drop_first() { first_.reset(); }
  void go_on();

  [[nodiscard]] bool idle() const { return !current_ && !first_ && queue_.empty(); }
  // For good.
  [[nodiscard]] bool lost() const { return lost_; }
  // For the way out: blocks.
  void write_and_wait(std::string_view bytes) { channel_.write_and_wait(bytes, table_.gap); }

  [[nodiscard]] std::string called() const;  // "the projector at /dev/ttyUSB0"
  // The last reply that was not Ok, in a sentence with the port and what came back; or what else came up.
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
  TimePoint free_at_{};           // the gap is over
  std::unique_ptr<Timer> timer_;  // of the current request: its gap, then its reply
  std::string problem_;
  bool lost_ = false;
};

}  // namespace contourd
