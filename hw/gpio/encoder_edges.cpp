#include "hw/gpio/encoder_edges.hpp"

#include <algorithm>
#include <span>

namespace contourd {

EncoderEdges::EncoderEdges(InputLine* a, InputLine* b) noexcept {
  a_.line = a;
  b_.line = b;
  if (a == nullptr || b == nullptr) return;
  // One that cannot be read shows by its edges, which do not fit.
  quadrature_ = Quadrature(a->level().value_or(false), b->level().value_or(false));
}

void EncoderEdges::Channel::read() noexcept {
  while (kept < edges.size()) {
    const std::size_t count = line->read_edges(std::span(edges).subspan(kept));
    if (count == 0) return;
    kept += count;
  }
}

void EncoderEdges::Channel::drop(std::size_t count) noexcept {
  std::copy(edges.begin() + static_cast<std::ptrdiff_t>(count),
            edges.begin() + static_cast<std::ptrdiff_t>(kept), edges.begin());
  kept -= count;
}

void EncoderEdges::serve(TimePoint now) noexcept {
  if (a_.line == nullptr || b_.line == nullptr) return;
  a_.read();
  b_.read();
  std::size_t a = 0, b = 0;
  const auto ready = [now](const Channel& channel, std::size_t i) {
    return i < channel.kept && now - channel.edges[i].at >= kHandedOver;
  };
  while (ready(a_, a) || ready(b_, b)) {
    const bool a_first = b >= b_.kept || (a < a_.kept && a_.edges[a].at <= b_.edges[b].at);
    if (a_first) {
      quadrature_.edge_a(a_.edges[a++].active);
    } else {
      quadrature_.edge_b(b_.edges[b++].active);
    }
  }
  a_.drop(a);
  b_.drop(b);
}

std::optional<TimePoint> EncoderEdges::due() const noexcept {
  std::optional<TimePoint> first;
  for (const Channel* channel : {&a_, &b_}) {
    if (channel->kept > 0 && (!first || channel->edges[0].at < *first)) first = channel->edges[0].at;
  }
  return first ? std::optional(*first + kHandedOver) : std::nullopt;
}

}  // namespace contourd
