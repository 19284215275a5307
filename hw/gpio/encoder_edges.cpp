#include "hw/gpio/encoder_edges.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace contourd {

EncoderEdges::EncoderEdges(InputLine* a, InputLine* b, InputLine* index) noexcept {
  a_.line = a;
  b_.line = b;
  mark_.line = index;
  if (a == nullptr || b == nullptr) return;
  // If a level cannot be read, the edges will not fit it and are counted as illegal.
  quadrature_ = Quadrature(a->level().value_or(false), b->level().value_or(false));
}

void EncoderEdges::Channel::read() noexcept {
  while (line != nullptr && kept < edges.size()) {
    const std::size_t count = line->read_edges(std::span(edges).subspan(kept));
    if (count == 0) return;
    kept += count;
    read_ever += count;
  }
}

void EncoderEdges::Channel::drop() noexcept {
  std::copy(edges.begin() + static_cast<std::ptrdiff_t>(counted),
            edges.begin() + static_cast<std::ptrdiff_t>(kept), edges.begin());
  kept -= std::exchange(counted, 0);
}

EncoderEdges::Channel* EncoderEdges::earliest() noexcept {
  Channel* first = nullptr;
  // Among edges with the same time the mark's is last: it belongs to the count after the others.
  for (Channel* channel : {&a_, &b_, &mark_}) {
    if (channel->waits() && (first == nullptr || channel->first().at < first->first().at)) first = channel;
  }
  return first;
}

void EncoderEdges::count(const Channel& channel) noexcept {
  const bool active = channel.first().active;
  if (&channel == &a_) return quadrature_.edge_a(active);
  if (&channel == &b_) return quadrature_.edge_b(active);
  if (active != quadrature_.upwards()) return;
  index_count_ = quadrature_.count();
  ++index_pulses_;
}

void EncoderEdges::serve(TimePoint now) noexcept {
  if (a_.line == nullptr || b_.line == nullptr) return;
  for (Channel* channel : {&a_, &b_, &mark_})
    channel->read();
  for (Channel* first = earliest(); first != nullptr && now - first->first().at >= kHandedOver;
       first = earliest()) {
    count(*first);
    ++first->counted;
  }
  for (Channel* channel : {&a_, &b_, &mark_})
    channel->drop();
}

std::uint64_t EncoderEdges::edges(EncoderLine which) const noexcept {
  return std::array{&a_, &b_, &mark_}[static_cast<std::size_t>(which)]->read_ever;
}

std::optional<TimePoint> EncoderEdges::due() const noexcept {
  std::optional<TimePoint> first;
  for (const Channel* channel : {&a_, &b_, &mark_}) {
    if (channel->kept > 0 && (!first || channel->edges[0].at < *first)) first = channel->edges[0].at;
  }
  return first ? std::optional(*first + kHandedOver) : std::nullopt;
}

}  // namespace contourd
