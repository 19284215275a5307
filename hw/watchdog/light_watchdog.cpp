#include "hw/watchdog/light_watchdog.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

namespace contourd {
namespace {

constexpr int kStartPatienceMs = 5'000;

std::string refused(const char* what, int error) {
  return std::string("the system denies the light watchdog ") + what + " (" +
         std::generic_category().message(error) + "): it works, but may be late when the machine is busy";
}

std::string sentence(LightTrip trip) {
  const std::string off = "the light watchdog has turned the light off: ";
  if (trip == LightTrip::Overrun) return off + "the exposure was over and contourd had not";
  return off + "contourd had not answered in time";
}

// Reaps the process. True if it is gone, or was never there.
bool reap(pid_t process) {
  return process < 0 || ::waitpid(process, nullptr, WNOHANG) != 0;
}

}  // namespace

LightWatchdog::LightWatchdog(Clock& clock, DescriptorWatcher& watcher, Start start)
    : clock_(clock), watcher_(watcher), start_(std::move(start)) {
  problem_ = "the light watchdog has not started yet";
  this->start();
  wait_until_ready();
}

LightWatchdog::~LightWatchdog() {
  last_light_off().set({});
}

// --- The process ---

void LightWatchdog::start() {
  try {
    process_ = start_();
    watch_ = watcher_.when_readable(process_.socket.get(), [this] { hear_all(); });
  } catch (const std::exception& error) {
    lose(std::string("cannot be started: ") + error.what());
  }
}

void LightWatchdog::wait_until_ready() {
  pollfd readable{process_.socket.get(), POLLIN, 0};
  if (process_.socket.valid() && ::poll(&readable, 1, kStartPatienceMs) > 0) hear_all();
}

void LightWatchdog::lose(const std::string& why) {
  problem_ = "the light watchdog " + why + "; no light is turned on without it";
  watch_.reset();
  armed_ = nullptr;
  process_.socket = FileDescriptor();
  if (process_.id > 0) ::kill(process_.id, SIGKILL);
  restart_ = clock_.call_after(process_.id > 0 ? kStartAgain : kStartLater, [this] { start_again(); });
  give_up();
}

void LightWatchdog::give_up() {
  heartbeat_.reset();
  if (std::exchange(watched_, std::nullopt)) tell_trouble(problem_);
}

// Reports from the event loop, because the caller may have more urgent things to do first, such as turning
// the light off.
void LightWatchdog::tell_trouble(const std::string& what) {
  tell_ = clock_.call_after(Duration{0}, [this, what] {
    if (trouble_) trouble_(what);
  });
}

// Waits until the old process is gone: the devices that it still holds could not be opened again.
void LightWatchdog::start_again() {
  if (!reap(process_.id)) {
    restart_ = clock_.call_after(kStartAgain, [this] { start_again(); });
    return;
  }
  process_.id = -1;
  start();
}

void LightWatchdog::ready(const WatchdogReply& reply) {
  readiness_ = reply;
  const std::string was = std::exchange(problem_, std::string());
  if (offers_.line.descriptor >= 0) offer(offers_.line);
  if (offers_.serial.descriptor >= 0) offer(offers_.serial);
  if (offers_.display.descriptor >= 0) offer(offers_.display);
  if (watched_) tell(WatchdogMessageType::Arm);
  if (recovered_) recovered_(was);
}

std::vector<std::string> LightWatchdog::refusals() const {
  std::vector<std::string> all;
  if (readiness_.no_priority != 0) all.push_back(refused("real-time priority", readiness_.no_priority));
  if (readiness_.no_memory_lock != 0) all.push_back(refused("locked memory", readiness_.no_memory_lock));
  return all;
}

// --- Descriptors that turn the light off ---

template <typename Message>
void LightWatchdog::offer(const LightOffer<Message>& offered) {
  last_light_off().set(offers_);
  if (problem_.empty()) send(offered.message, offered.descriptor);
}

void LightWatchdog::set_line(int descriptor) {
  if (descriptor < 0 && offers_.line.descriptor < 0) return;
  offers_.line.descriptor = descriptor;
  offer(offers_.line);
}

void LightWatchdog::set_serial(const LightSerialPath& path) {
  const bool fits = !path.light_off.empty() && path.light_off.size() <= SerialMessage::kMaxBytes;
  if (!fits && offers_.serial.descriptor < 0) return;
  offers_.serial.descriptor = fits ? path.descriptor : -1;
  offers_.serial.message.size = fits ? static_cast<std::uint32_t>(path.light_off.size()) : 0;
  offers_.serial.message.gap = path.gap;
  if (fits) std::ranges::copy(path.light_off, offers_.serial.message.light_off.begin());
  offer(offers_.serial);
}

void LightWatchdog::set_display(const LightDisplayPath& path) {
  if (path.descriptor < 0 && offers_.display.descriptor < 0) return;
  offers_.display.descriptor = path.descriptor;
  offers_.display.message = {WatchdogMessageType::Display, path.crtc, path.connector, path.black, path.mode};
  offer(offers_.display);
}

// --- An exposure ---

void LightWatchdog::arm(Duration exposure, std::function<void()> armed) {
  trip_.reset();
  watched_ = Watched{{++exposures_, clock_.now() + exposure, false}, exposure, false, 0};
  armed_ = std::move(armed);
  heartbeat_ = clock_.call_after(kHeartbeat, [this] { heartbeat(); });
  if (problem_.empty()) tell(WatchdogMessageType::Arm);
}

void LightWatchdog::begins(TimePoint end) {
  if (!watched_) return;
  watched_->begun = true;
  watched_->exposure.end = end;
  tell(WatchdogMessageType::Heartbeat);
}

void LightWatchdog::off_asked() {
  if (!watched_ || watched_->exposure.off_asked) return;
  armed_ = nullptr;
  watched_->exposure.off_asked = true;
  tell(WatchdogMessageType::Heartbeat);
}

void LightWatchdog::disarm() {
  if (!watched_) return;
  heartbeat_.reset();
  armed_ = nullptr;
  const WatchedExposure exposure = watched_->exposure;
  watched_.reset();
  if (problem_.empty()) send(ExposureMessage{WatchdogMessageType::Disarm, exposure, clock_.now()});
}

void LightWatchdog::heartbeat() {
  heartbeat_ = clock_.call_after(kHeartbeat, [this] { heartbeat(); });
  // This process may have been suspended while the answers arrived.
  hear_all();
  if (!watched_) return;
  if (watched_->unanswered < kMaxUnanswered) return tell(WatchdogMessageType::Heartbeat);
  problem_.empty() ? lose("does not answer") : give_up();
}

void LightWatchdog::tell(WatchdogMessageType type) {
  ++watched_->unanswered;
  // Until light on is sent the exposure has not begun, and its end moves on.
  if (!watched_->begun) watched_->exposure.end = clock_.now() + watched_->asked;
  if (problem_.empty()) send(ExposureMessage{type, watched_->exposure, clock_.now()});
}

// A message that cannot be sent is noticed by the end of the socket, or by answers that do not come.
template <typename Message>
void LightWatchdog::send(const Message& message, int descriptor) {
  (void)send_message(process_.socket.get(), message, descriptor);
}

// --- Answers ---

void LightWatchdog::hear_all() {
  WatchdogPacket packet;
  while (process_.socket.valid()) {
    switch (receive_packet(process_.socket.get(), packet)) {
      case Received::Nothing:
        return;
      case Received::End:
        return lose("has died");
      case Received::Packet:
        if (const auto reply = packet.as<WatchdogReply>()) hear(*reply);
    }
  }
}

const std::optional<WatchdogTrip>& LightWatchdog::trip() {
  hear_all();
  return trip_;
}

void LightWatchdog::hear(const WatchdogReply& reply) {
  if (reply.type == WatchdogMessageType::Ready) return ready(reply);
  if (!watched_ || reply.exposure != watched_->exposure.number) return;
  if (reply.type == WatchdogMessageType::Tripped) {
    trip_ = WatchdogTrip{reply.trip, reply.at, reply.line_off};
    return tell_trouble(sentence(reply.trip));
  }
  watched_->unanswered = 0;
  if (armed_) std::exchange(armed_, nullptr)();
}

}  // namespace contourd
