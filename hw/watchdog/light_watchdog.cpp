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
  return std::string("the system refuses ") + what + " to the light watchdog (" +
         std::generic_category().message(error) + "): it works, and may be late when the machine is busy";
}

std::string sentence(LightTrip trip) {
  const std::string off = "the light watchdog has turned the light off: ";
  if (trip == LightTrip::Overrun) return off + "the exposure was over and contourd had not";
  return off + "contourd had not answered it in time";
}

// True when it is gone, or was never there.
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

LightWatchdog::~LightWatchdog() = default;

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
  beat_.reset();
  if (std::exchange(watched_, std::nullopt)) tell_trouble(problem_);
}

// Not from within a call of whoever has more to do first, such as turning the light off.
void LightWatchdog::tell_trouble(const std::string& what) {
  tell_ = clock_.call_after(Duration{0}, [this, what] {
    if (trouble_) trouble_(what);
  });
}

// Not before the old one is gone, and with it the devices that it had: they could not be opened again.
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
  if (line_.descriptor >= 0) offer(line_);
  if (serial_.descriptor >= 0) offer(serial_);
  if (display_.descriptor >= 0) offer(display_);
  if (watched_) tell(WatchdogWord::Arm);
  if (recovered_) recovered_(was);
}

std::vector<std::string> LightWatchdog::refusals() const {
  std::vector<std::string> all;
  if (readiness_.no_priority != 0) all.push_back(refused("real-time priority", readiness_.no_priority));
  if (readiness_.no_memory_lock != 0) all.push_back(refused("locked memory", readiness_.no_memory_lock));
  return all;
}

// --- What it turns the light off by ---

template <typename Message>
void LightWatchdog::offer(const Offer<Message>& offered) {
  if (problem_.empty()) send(offered.message, offered.descriptor);
}

void LightWatchdog::set_line(int descriptor) {
  if (descriptor < 0 && line_.descriptor < 0) return;
  line_.descriptor = descriptor;
  offer(line_);
}

void LightWatchdog::set_serial(const LightSerialPath& path) {
  const bool fits = !path.light_off.empty() && path.light_off.size() <= SerialMessage::kMostBytes;
  if (!fits && serial_.descriptor < 0) return;
  serial_.descriptor = fits ? path.descriptor : -1;
  serial_.message.size = fits ? static_cast<std::uint32_t>(path.light_off.size()) : 0;
  serial_.message.gap = path.gap;
  if (fits) std::ranges::copy(path.light_off, serial_.message.light_off.begin());
  offer(serial_);
}

void LightWatchdog::set_display(const LightDisplayPath& path) {
  if (path.descriptor < 0 && display_.descriptor < 0) return;
  display_.descriptor = path.descriptor;
  display_.message = {WatchdogWord::Display, path.crtc, path.connector, path.black, path.mode};
  offer(display_);
}

// --- An exposure ---

void LightWatchdog::arm(Duration exposure, std::function<void()> armed) {
  trip_.reset();
  watched_ = Watched{{++exposures_, clock_.now() + exposure, false}, exposure, false, 0};
  armed_ = std::move(armed);
  beat_ = clock_.call_after(kBeat, [this] { beat(); });
  if (problem_.empty()) tell(WatchdogWord::Arm);
}

void LightWatchdog::begins(TimePoint end) {
  if (!watched_) return;
  watched_->begun = true;
  watched_->exposure.end = end;
  tell(WatchdogWord::Beat);
}

void LightWatchdog::off_asked() {
  if (!watched_ || watched_->exposure.off_asked) return;
  armed_ = nullptr;
  watched_->exposure.off_asked = true;
  tell(WatchdogWord::Beat);
}

void LightWatchdog::disarm() {
  if (!watched_) return;
  beat_.reset();
  armed_ = nullptr;
  const WatchedExposure exposure = watched_->exposure;
  watched_.reset();
  if (problem_.empty()) send(ExposureMessage{WatchdogWord::Disarm, exposure, clock_.now()});
}

void LightWatchdog::beat() {
  beat_ = clock_.call_after(kBeat, [this] { beat(); });
  // This process may have slept, and the answers lie there.
  hear_all();
  if (!watched_) return;
  if (watched_->unanswered < kMostUnanswered) return tell(WatchdogWord::Beat);
  problem_.empty() ? lose("does not answer") : give_up();
}

void LightWatchdog::tell(WatchdogWord word) {
  ++watched_->unanswered;
  // Until light on is sent, the exposure has yet to begin.
  if (!watched_->begun) watched_->exposure.end = clock_.now() + watched_->asked;
  if (problem_.empty()) send(ExposureMessage{word, watched_->exposure, clock_.now()});
}

// What it does not take is found out by the end of the socket, or by the answers that do not come.
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
  if (reply.word == WatchdogWord::Ready) return ready(reply);
  if (!watched_ || reply.exposure != watched_->exposure.number) return;
  if (reply.word == WatchdogWord::Tripped) {
    trip_ = WatchdogTrip{reply.trip, reply.at, reply.line_off};
    return tell_trouble(sentence(reply.trip));
  }
  watched_->unanswered = 0;
  if (armed_) std::exchange(armed_, nullptr)();
}

}  // namespace contourd
