#include "hw/gpio/axis_inputs.hpp"

#include <algorithm>
#include <span>

namespace contourd {
namespace {

// How often levels are read while something moves, in case the kernel had no room for an edge.
constexpr Duration kReadLevels{std::chrono::milliseconds{20}};

constexpr std::array kContacts{AxisInput::LimitSwitch, AxisInput::SecondSwitch, AxisInput::EmergencyStop,
                               AxisInput::Lid};

void keep_earlier(std::optional<TimePoint>& first, std::optional<TimePoint> other) noexcept {
  if (other && (!first || *other < *first)) first = other;
}

}  // namespace

AxisInputs::AxisInputs(StepEngine& engine, const Lines& lines, StepEngine::Now now)
    : engine_(engine), lines_(lines), now_(now), encoder_(lines.encoder_a, lines.encoder_b) {
  for (const AxisInput which : kContacts) {
    const Contact& contact = lines_.contacts[index(which)];
    const bool level = contact.line != nullptr && contact.line->level();
    contacts_[index(which)] = Debounce(contact.debounce, level);
    settled_[index(which)] = level;
  }
  if (active(AxisInput::EmergencyStop)) engine_.bar();
}

void AxisInputs::set_limit_rule(LimitRule rule, std::int64_t limit, bool from_above) noexcept {
  limit_ = limit;
  from_above_ = from_above;
  limit_rule_ = rule;
  work_.signal();
}

void AxisInputs::watch_second_switch(bool watched) noexcept {
  second_watched_ = watched;
  work_.signal();
}

std::optional<InputChange> AxisInputs::take_change() noexcept {
  const std::uint32_t taken = taken_.load(std::memory_order_relaxed);
  if (taken == told_.load(std::memory_order_acquire)) return std::nullopt;
  const InputChange change = ring_[taken % kChanges];
  taken_.store(taken + 1, std::memory_order_release);
  return change;
}

void AxisInputs::tell(const InputChange& change) noexcept {
  const std::uint32_t told = told_.load(std::memory_order_relaxed);
  if (told - taken_.load(std::memory_order_acquire) == kChanges) return lose();
  ring_[told % kChanges] = change;
  told_.store(told + 1, std::memory_order_release);
  changed_.signal();
}

void AxisInputs::lose() noexcept {
  engine_.bar();
  lost_ = true;
  changed_.signal();
}

std::array<pollfd, AxisInputs::kDescriptors> AxisInputs::descriptors() const noexcept {
  const auto waited = [](const InputLine* line) {
    return pollfd{line != nullptr ? line->descriptor() : -1, POLLIN, 0};  // poll() passes over a negative one
  };
  std::array<pollfd, kDescriptors> all{};
  for (std::size_t i = 0; i < kAxisInputs; ++i)
    all[i] = waited(lines_.contacts[i].line);
  all[kAxisInputs] = waited(lines_.encoder_a);
  all[kAxisInputs + 1] = waited(lines_.encoder_b);
  all[kAxisInputs + 2] = pollfd{work_.descriptor(), POLLIN, 0};
  return all;
}

std::optional<TimePoint> AxisInputs::serve() noexcept {
  const TimePoint now = now_();
  work_.clear();
  for (const AxisInput which : kContacts)
    take_edges(which);
  encoder_.serve(now);
  count_ = encoder_.counted().count();
  illegal_ = encoder_.counted().illegal();
  if (now - levels_read_ >= kReadLevels) read_levels(now);
  for (const AxisInput which : kContacts)
    settle(which, now);
  apply_rules();
  std::optional<TimePoint> next = encoder_.due();
  for (const Debounce& contact : contacts_)
    keep_earlier(next, contact.due());
  if (watching()) keep_earlier(next, levels_read_ + kReadLevels);
  return next;
}

bool AxisInputs::watching() const noexcept {
  return limit_rule_ != LimitRule::Never || second_watched_;
}

void AxisInputs::take_edges(AxisInput which) noexcept {
  InputLine* line = lines_.contacts[index(which)].line;
  if (line == nullptr) return;
  std::array<LineEdge, 16> edges;
  // Not without end, even where edges come faster than they can be read.
  for (int rounds = 0; rounds < 16; ++rounds) {
    const std::size_t count = line->read_edges(edges);
    for (const LineEdge& edge : std::span(edges).first(count))
      at_edge(which, edge);
    if (count < edges.size()) return;
  }
}

void AxisInputs::at_edge(AxisInput which, const LineEdge& edge) noexcept {
  contacts_[index(which)].edge(edge.active, edge.at);
  if (!edge.active) return;
  if (which == AxisInput::LimitSwitch && limit_rule_ == LimitRule::AtContact) {
    engine_.halt_soon();
    limit_rule_ = LimitRule::Never;
    halted_[index(which)] = true;
  }
  // At once, unless the line is back already: a spike.
  if (which == AxisInput::EmergencyStop && lines_.contacts[index(which)].line->level()) engine_.bar();
}

void AxisInputs::read_levels(TimePoint now) noexcept {
  levels_read_ = now;
  for (const AxisInput which : kContacts) {
    InputLine* line = lines_.contacts[index(which)].line;
    if (line == nullptr) continue;
    const bool level = line->level();
    // No later than this; if its event is still to come, that has its time.
    if (level != contacts_[index(which)].raw()) at_edge(which, {level, now_()});
  }
}

void AxisInputs::settle(AxisInput which, TimePoint now) noexcept {
  Debounce& contact = contacts_[index(which)];
  if (!contact.due() || now < *contact.due()) return;
  const bool level = lines_.contacts[index(which)].line->level();  // the truth
  contact.read(level, now_());
  const auto settled = contact.settle(now);
  if (!settled) return;
  settled_[index(which)] = settled->level;
  if (which == AxisInput::EmergencyStop && settled->level) engine_.bar();
  const bool halted = halted_[index(which)];
  halted_[index(which)] = false;
  tell({which, settled->level, settled->changed, halted, settled->since});
}

bool AxisInputs::out_of_place(std::int64_t position) const noexcept {
  return from_above_ ? position < limit_ : position > limit_;
}

void AxisInputs::apply_rules() noexcept {
  const Debounce& limit = contacts_[index(AxisInput::LimitSwitch)];
  if (limit_rule_ == LimitRule::AtContact && limit.raw()) {
    at_edge(AxisInput::LimitSwitch, {true, now_()});
  }
  if (limit_rule_ == LimitRule::Beyond && limit.settled() && out_of_place(engine_.position())) {
    limit_rule_ = LimitRule::Never;
    tell({AxisInput::LimitSwitch, true, false, true,
          now_()});  // first, so that a halt never comes without its cause
    engine_.halt_soon();
  }
  if (second_watched_ && contacts_[index(AxisInput::SecondSwitch)].settled()) {
    second_watched_ = false;
    tell({AxisInput::SecondSwitch, true, false, true, now_()});
    engine_.halt_soon();
  }
}

}  // namespace contourd
