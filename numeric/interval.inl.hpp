// Include inside a namespace; see numeric/sine_cosine.inl.hpp.

/// Whether a step from `at` leads out of the interval from `lower` to `upper`: from one of its ends, or outwards from
/// outside. A solver that respects limits leaves such joints out and solves again.
template <class Number>
inline auto leads_out(Number at, Number lower, Number upper, Number step) {
  return ((at <= lower) & (step < 0)) | ((at >= upper) & (step > 0));
}
