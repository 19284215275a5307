#include "hw/gpio/axis_inputs.hpp"

#include <sched.h>

#include <algorithm>
#include <span>
#include <utility>

namespace contourd {
namespace {

// How often levels are read, in case the kernel had no room for an edge: while a switch is watched, and
// always if there is a safety input.
constexpr Duration kReadLevels{std::chrono::milliseconds{20}};
// How often the position is compared while a motor moves on under a force.
constexpr Duration kFollowForce{std::chrono::milliseconds{2}};
// The light is cut a second time this long after a first edge. The event loop may have been turning it on and
// have lost its processor before it could see the first cut.
constexpr Duration kCutAgain{std::chrono::milliseconds{2}};

// The contacts in the order of urgency.
constexpr std::array kContacts{AxisInput::EmergencyStop, AxisInput::Lid,          AxisInput::PowerFail,
                               AxisInput::LimitSwitch,   AxisInput::SecondSwitch, AxisInput::Force};
constexpr std::array kSafetyInputs{AxisInput::EmergencyStop, AxisInput::Lid, AxisInput::PowerFail};
constexpr std::array kSwitches{AxisInput::LimitSwitch, AxisInput::SecondSwitch, AxisInput::Force};

bool is_safety(AxisInput which) noexcept {
  return std::ranges::find(kSafetyInputs, which) != kSafetyInputs.end();
}

void keep_earlier(std::optional<TimePoint>& first, std::optional<TimePoint> other) noexcept {
  if (other && (!first || *other < *first)) first = other;
}

}  // namespace

AxisInputs::AxisInputs(StepEngine& engine, const Lines& lines, StepEngine::Now now)
    : engine_(engine),
      lines_(lines),
      now_(now),
      encoder_(lines.encoder_a, lines.encoder_b, lines.encoder_index) {
  for (const AxisInput which : kContacts) {
    const Contact& contact = lines_.contacts[index(which)];
    if (contact.line == nullptr) continue;
    const bool level = level_of(which);
    if (is_safety(which)) {
      safety_[index(which)] = SafetyContact(contact.debounce, level);
      put(which, safety_[index(which)].state());
    } else {
      switches_[index(which)] = Debounce(contact.debounce, level);
      active_[index(which)] = level;
    }
  }
  if (active(AxisInput::EmergencyStop)) engine_.inhibit();
}

void AxisInputs::set_limit_rule(LimitRule rule, std::int64_t limit, bool from_above) noexcept {
  // The limit of a rule that still holds is not touched.
  if (rule != LimitRule::Never) {
    limit_ = limit;
    from_above_ = from_above;
  }
  limit_rule_ = rule;
  work_.signal();
}

void AxisInputs::watch_second_switch(bool watched) noexcept {
  second_watched_ = watched;
  work_.signal();
}

void AxisInputs::set_force_rule(ForceRule rule, std::int64_t limit) noexcept {
  // The limit of a rule that still holds is not touched.
  if (rule != ForceRule::Never) force_limit_ = limit;
  force_rule_ = rule;
  work_.signal();
}

void AxisInputs::set_light_cutoff(LightCutoff* cutoff) noexcept {
  cutoff_ = cutoff;
  // Sequentially consistent on both sides: either the input thread sees the new cutoff, or this loop sees
  // that the old one is in use.
  while (cutting_)
    sched_yield();
  release_light();
}

// let_go() and release_light() check the inputs again after undoing: the input thread marks an input as
// unsafe before it inhibits and cuts.

void AxisInputs::let_go() noexcept {
  const auto stopped = [this] {
    return lost_ || states_[index(AxisInput::EmergencyStop)] == SafetyState::Unsafe;
  };
  if (!stopped()) engine_.enable();
  if (stopped()) engine_.inhibit();
  release_light();
}

void AxisInputs::release_light() noexcept {
  LightCutoff* const cutoff = cutoff_;
  if (cutoff == nullptr) return;
  if (!unsafe()) cutoff->release();
  if (unsafe()) cutoff->cut(now_());
}

std::optional<InputChange> AxisInputs::take_change() noexcept {
  const std::uint32_t taken = taken_.load(std::memory_order_relaxed);
  if (taken == added_.load(std::memory_order_acquire)) return std::nullopt;
  const InputChange change = ring_[taken % kChanges];
  taken_.store(taken + 1, std::memory_order_release);
  return change;
}

void AxisInputs::add_change(const InputChange& change) noexcept {
  const std::uint32_t added = added_.load(std::memory_order_relaxed);
  if (added - taken_.load(std::memory_order_acquire) == kChanges) return lose();
  ring_[added % kChanges] = change;
  added_.store(added + 1, std::memory_order_release);
  changed_.signal();
}

void AxisInputs::lose() noexcept {
  lost_ = true;
  cut_light();
  engine_.inhibit();
  changed_.signal();
}

void AxisInputs::cut_light() noexcept {
  cutting_ = true;
  if (LightCutoff* const cutoff = cutoff_) cutoff->cut(now_());
  cutting_ = false;
}

void AxisInputs::cut_again(TimePoint now) noexcept {
  if (!cut_again_at_ || now < *cut_again_at_) return;
  cut_again_at_.reset();
  if (unsafe()) cut_light();
}

std::array<pollfd, AxisInputs::kDescriptors> AxisInputs::descriptors() const noexcept {
  const auto waited = [](const InputLine* line) {
    return pollfd{line != nullptr ? line->descriptor() : -1, POLLIN, 0};  // poll() ignores negative ones
  };
  std::array<pollfd, kDescriptors> all{};
  for (std::size_t i = 0; i < kAxisInputs; ++i)
    all[i] = waited(lines_.contacts[i].line);
  all[kAxisInputs] = waited(lines_.encoder_a);
  all[kAxisInputs + 1] = waited(lines_.encoder_b);
  all[kAxisInputs + 2] = waited(lines_.encoder_index);
  all[kAxisInputs + 3] = pollfd{work_.descriptor(), POLLIN, 0};
  return all;
}

std::optional<TimePoint> AxisInputs::serve() noexcept {
  const TimePoint now = served_ = now_();
  work_.clear();
  for (const AxisInput which : kContacts)
    take_edges(which);
  encoder_.serve(now);
  count_ = encoder_.counted().count();
  illegal_ = encoder_.counted().illegal();
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    encoder_edges_[line] = encoder_.edges(static_cast<EncoderLine>(line));
  index_count_ = encoder_.index_count();
  index_pulses_ = encoder_.index_pulses();
  if (now - levels_read_ >= kReadLevels) read_levels(now);
  for (const AxisInput which : kSafetyInputs)
    settle_safety(which, now);
  for (const AxisInput which : kSwitches)
    settle_switch(which, now);
  cut_again(now);
  apply_rules();
  return next_due();
}

std::optional<TimePoint> AxisInputs::next_due() const noexcept {
  std::optional<TimePoint> next = encoder_.due();
  for (const AxisInput which : kSwitches)
    keep_earlier(next, switches_[index(which)].due());
  for (const AxisInput which : kSafetyInputs)
    keep_earlier(next, safety_[index(which)].due());
  keep_earlier(next, cut_again_at_);
  if (pressed_from_) keep_earlier(next, served_ + kFollowForce);
  if (watching()) keep_earlier(next, levels_read_ + kReadLevels);
  return next;
}

bool AxisInputs::watching() const noexcept {
  const auto fitted = [this](AxisInput which) { return lines_.contacts[index(which)].line != nullptr; };
  return limit_rule_ != LimitRule::Never || second_watched_ || fitted(AxisInput::Force) ||
         std::ranges::any_of(kSafetyInputs, fitted);
}

void AxisInputs::take_edges(AxisInput which) noexcept {
  InputLine* line = lines_.contacts[index(which)].line;
  if (line == nullptr) return;
  std::array<LineEdge, 16> edges;
  // A limited number of rounds, in case edges come faster than they can be read.
  for (int rounds = 0; rounds < 16; ++rounds) {
    const std::size_t count = line->read_edges(edges);
    edges_[index(which)] += count;
    for (const LineEdge& edge : std::span(edges).first(count))
      at_edge(which, edge);
    if (count < edges.size()) return;
  }
}

void AxisInputs::at_edge(AxisInput which, const LineEdge& edge) noexcept {
  if (!is_safety(which)) return at_switch_edge(which, edge);
  safety_[index(which)].edge(edge.active, edge.at);
  if (active(which)) return;
  put(which, SafetyState::Debouncing);
  cut_light();
  cut_again_at_ = now_() + kCutAgain;
}

void AxisInputs::at_switch_edge(AxisInput which, const LineEdge& edge) noexcept {
  switches_[index(which)].edge(edge.active, edge.at);
  if (!edge.active) return;
  if (which == AxisInput::LimitSwitch && limit_rule_ == LimitRule::AtContact) {
    engine_.halt_soon();
    limit_rule_ = LimitRule::Never;
    halted_[index(which)] = true;
  }
}

void AxisInputs::put(AxisInput which, SafetyState state) noexcept {
  states_[index(which)] = state;
  active_[index(which)] = state != SafetyState::Safe;
}

// Reads the level. A safety input that cannot be read counts as unsafe; a switch that cannot be read loses
// the inputs and keeps its last level.
bool AxisInputs::level_of(AxisInput which) noexcept {
  const std::optional<bool> level = lines_.contacts[index(which)].line->level();
  unreadable_[index(which)] = !level;
  if (level) return *level;
  if (is_safety(which)) return true;
  if (!lost_) lose();
  return last_level(which);
}

// Reads the level. A change since the last known level counts as an edge whose event is missing.
bool AxisInputs::look_at(AxisInput which) noexcept {
  const bool level = level_of(which);
  if (level != last_level(which)) ++edges_[index(which)];
  return level;
}

bool AxisInputs::last_level(AxisInput which) const noexcept {
  return is_safety(which) ? safety_[index(which)].unsafe_level() : switches_[index(which)].raw();
}

void AxisInputs::read_levels(TimePoint now) noexcept {
  levels_read_ = now;
  for (const AxisInput which : kContacts) {
    if (lines_.contacts[index(which)].line == nullptr) continue;
    const bool level = look_at(which);
    // The edge was no later than now. If its event is still to come, that has the exact time.
    if (level != last_level(which)) at_edge(which, {level, now_()});
  }
}

void AxisInputs::settle_switch(AxisInput which, TimePoint now) noexcept {
  Debounce& contact = switches_[index(which)];
  if (!contact.due() || now < *contact.due()) return;
  const bool level = look_at(which);  // the level counts, not the events
  contact.read(level, now_());
  const auto settled = contact.settle(now);
  if (!settled) return;
  active_[index(which)] = settled->level;
  // A force that comes and goes must not lose the inputs; only the record of peels suffers.
  const bool crowded = added_ - taken_ > kChanges / 2;
  if (which == AxisInput::Force && (crowded || !settled->changed)) return;
  add_change({.which = which,
              .active = settled->level,
              .halted = std::exchange(halted_[index(which)], false),
              .at = settled->since});
}

void AxisInputs::settle_safety(AxisInput which, TimePoint now) noexcept {
  SafetyContact& contact = safety_[index(which)];
  if (!contact.due()) return;
  if (now >= *contact.due()) contact.read(look_at(which), now_());
  while (const auto change = contact.change(now)) {
    put(which, change->to);
    if (which == AxisInput::EmergencyStop && change->to == SafetyState::Unsafe) engine_.inhibit();
    add_change({.which = which,
                .active = change->to != SafetyState::Safe,
                .at = change->since,
                .from = change->from,
                .to = change->to,
                .readable = readable(which)});
  }
}

void AxisInputs::apply_rules() noexcept {
  const Debounce& limit = switches_[index(AxisInput::LimitSwitch)];
  if (limit_rule_ == LimitRule::AtContact && limit.raw()) at_edge(AxisInput::LimitSwitch, {true, now_()});
  // The cause is queued before the halt, so that no halt is seen without its cause.
  if (limit_rule_ == LimitRule::Beyond && limit.settled() && out_of_place(engine_.position())) {
    limit_rule_ = LimitRule::Never;
    add_change({.which = AxisInput::LimitSwitch, .active = true, .halted = true, .at = now_()});
    engine_.halt_soon();
  }
  if (second_watched_ && switches_[index(AxisInput::SecondSwitch)].settled()) {
    second_watched_ = false;
    add_change({.which = AxisInput::SecondSwitch, .active = true, .halted = true, .at = now_()});
    engine_.halt_soon();
  }
  if (meets_resistance()) {
    force_rule_ = ForceRule::Never;
    add_change({.which = AxisInput::Force, .active = true, .halted = true, .at = now_()});
    engine_.brake_soon();
  }
}

bool AxisInputs::meets_resistance() noexcept {
  const ForceRule rule = force_rule_;
  const std::int64_t position = engine_.position();
  const bool pressed = rule != ForceRule::Never && switches_[index(AxisInput::Force)].settled();
  if (pressed && rule == ForceRule::Above) return position > force_limit_;
  if (!pressed || rule == ForceRule::Above) return pressed_from_.reset(), false;
  if (!pressed_from_) pressed_from_ = position;
  return *pressed_from_ - position >= force_limit_;
}

}  // namespace contourd
