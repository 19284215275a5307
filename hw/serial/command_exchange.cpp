#include "hw/serial/command_exchange.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace contourd {
namespace {

using namespace std::chrono_literals;

// Number of timeouts for which a reply, though late, is still assigned to its command. A reply that comes
// later would be taken for a later command's.
constexpr int kLateTimeouts = 2;
// Timeout assumed at least for late replies to light on: taken for light off's, such a reply would make a lit
// projector count as dark. Equal to the longest timeout that a table can have.
constexpr Duration kLateLightOn = 30s;

}  // namespace

CommandExchange::CommandExchange(ByteChannel& channel, Clock& clock, const ProjectorTable& table,
                                 Listener listener)
    : channel_(channel), clock_(clock), table_(table), listener_(std::move(listener)), reader_(table) {
  channel_.listen({.bytes = [this](std::string_view bytes) { hear(bytes); },
                   .lost = [this](const std::string& why) { lose(why); }});
}

void CommandExchange::ask(const ProjectorCommand& command, std::function<void(const Answer&)> done,
                          bool stays) {
  ask({.command = &command, .done = std::move(done), .retries = table_.retries, .stays = stays});
}

void CommandExchange::ask(Request request) {
  request.id = new_id();
  queue_.push_back(std::move(request));
  go_on();
}

void CommandExchange::ask_first(Request request) {
  if (current_ && current_->command == request.command) return;
  first_ = std::move(request);
  go_on();
}

void CommandExchange::preempt(bool light_is_off) {
  std::erase_if(queue_, [](const Request& request) { return !request.stays; });
  const auto is = [this](const ProjectorCommand& command) { return current_->command == &command; };
  if (!current_ || (table_.light_off && is(*table_.light_off))) return;
  if (current_->stays) {
    if (!table_.light_off || (is(table_.power_off) && light_is_off)) return;
    queue_.push_front(std::move(*current_));
  }
  current_.reset();
  timer_.reset();
}

void CommandExchange::go_on() {
  if (current_) return;
  if (first_) {
    current_ = std::exchange(first_, std::nullopt);
  } else if (!queue_.empty()) {
    current_ = std::move(queue_.front());
    queue_.pop_front();
  } else {
    return;
  }
  current_->begun = clock_.now();
  reader_.forget();
  send();
}

void CommandExchange::send() {
  if (clock_.now() < free_at_) {
    timer_ = clock_.call_at(free_at_, [this] { send(); });
    return;
  }
  const ProjectorCommand& command = *current_->command;
  const TimePoint first_byte = clock_.now();
  if (lost_ || !channel_.write(command.bytes)) {
    // Deferred, so that the callback does not run inside the caller's call.
    timer_ = clock_.call_after(Duration{0}, [this] { give_up(); });
    return;
  }
  ++current_->sent;
  listener_.sent(command, first_byte);
  const TimePoint sent_at = clock_.now() + table_.wire_time(command);
  free_at_ = sent_at + table_.gap;
  const bool lights = table_.light_on && &command == &*table_.light_on;
  reader_.expect(current_->id, command, sent_at,
                 kLateTimeouts * (lights ? std::max(command.timeout, kLateLightOn) : command.timeout));
  if (command.replies.empty()) {
    timer_ = clock_.call_at(free_at_, [this] { finish({}); });
  } else {
    timer_ = clock_.call_at(sent_at + command.timeout, [this] { timed_out(); });
  }
}

void CommandExchange::hear(std::string_view bytes) {
  // Copied, because handling the bytes may lead to calls that come back here.
  const std::string all(bytes);
  for (const char byte : all)
    take(reader_.take(byte, clock_.now()));
}

void CommandExchange::take(const ReplyReader::Heard& heard) {
  if (heard.unasked != nullptr) return listener_.unasked(*heard.unasked);
  if (!heard.reply) return;
  free_at_ = clock_.now() + table_.gap;
  const bool own = current_ && heard.reply->request == current_->id;  // otherwise late, and another request's
  const Ambiguous if_ambiguous = current_ && current_->sent > 0 ? current_->if_ambiguous : Ambiguous::Counts;
  // Where the replies to light on and light off look alike, this may be either's: light on's may have been
  // lost, or come late or twice. The reply to another light off settles that sooner than a timeout. The same
  // applies to power off.
  if ((if_ambiguous == Ambiguous::SendsAgainAnyway && !own) ||
      (if_ambiguous != Ambiguous::Counts && heard.reply->ambiguous)) {
    timer_ = clock_.call_at(free_at_, [this] { send(); });
    return;
  }
  if (!own) return;
  if (heard.reply->meaning == ReplyMeaning::Refused) {
    problem_ = called() + " refused \"" + current_->command->name + "\": it answered " +
               readable_bytes(heard.reply->text);
    return finish({.reply = ProjectorReply::Refused, .meaning = ReplyMeaning::Refused});
  }
  finish({.meaning = heard.reply->meaning, .value = heard.reply->value, .ambiguous = heard.reply->ambiguous});
}

void CommandExchange::timed_out() {
  const RequestId id = current_->id;
  take(reader_.end_line(clock_.now()));
  if (!current_ || current_->id != id) return;
  if (current_->sent <= current_->retries) return send();
  give_up();
}

void CommandExchange::give_up() {
  problem_ = no_answer(*current_);
  finish({.reply = ProjectorReply::NoAnswer});
}

std::string CommandExchange::no_answer(const Request& request) const {
  if (lost_ || request.sent == 0) return called() + " cannot be reached: the serial line is lost";
  const std::string tried = std::to_string(request.sent) + (request.sent == 1 ? " try" : " tries");
  const std::string what = "\"" + request.command->name + "\" in " + tried + " of " +
                           std::to_string(request.command->timeout / 1ms) + " ms";
  const std::string baud = std::to_string(table_.baud);
  if (reader_.unexplained().empty())
    return called() + " did not answer " + what + ": is it connected, and set to " + baud + " baud?";
  return called() + " answered " + what + " with " + readable_bytes(reader_.unexplained()) +
         ", which is not a reply to it: is its baud rate " + baud + ", and is the table \"" + table_.name +
         "\" the right one for it?";
}

void CommandExchange::finish(Answer answer) {
  const Request request = std::move(*current_);
  current_.reset();
  timer_.reset();
  answer.begun = request.begun;
  answer.garbled = !reader_.unexplained().empty();
  if (request.done) request.done(answer);
  go_on();
}

void CommandExchange::lose(const std::string& why) {
  lost_ = true;
  if (current_) timer_ = clock_.call_after(Duration{0}, [this] { give_up(); });
  listener_.lost(why);
}

}  // namespace contourd
