// Approximate minimum degree: an order of elimination that keeps the factor sparse.
//
// P. R. Amestoy, T. A. Davis, I. S. Duff, An Approximate Minimum Degree Ordering Algorithm, SIAM J.
// Matrix Anal. Appl. 17, 1996, https://doi.org/10.1137/S0895479894278952
//
// Eliminating a vertex joins its neighbours into a clique. The quotient graph stores a clique as
// one element, the list of its members, instead of all its edges; a vertex then has a list of
// elements and a list of variables (neighbours that no element covers yet). Variables that became
// indistinguishable are merged and eliminated together.
//
// An element is what the column of the factor has below its diagonal, and it lasts until another
// one absorbs it. So the order comes with the tree in which columns hand down what is left of them,
// and with the number of their rows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/processor.hpp"
#include "linear/analysis.hpp"

namespace geodesic {
namespace {

constexpr Index kPrefetchDistance = 16;  // groups of prefetch distance

// `Place` holds where a list begins, and the largest mark.
template <class Place>
class QuotientGraph {
 public:
  explicit QuotientGraph(const Pattern& pattern)
      : n_(pattern.size()),
        nodes_(n_),
        lists_(2 * static_cast<Index>(pattern.indices.size()) + 2 * n_ + 64),
        links_(6 * n_ + 1),
        head_(links_.data()),
        bucket_(head_ + n_ + 1),
        next_member_(bucket_ + n_),
        bucket_next_(next_member_ + n_),
        hashes_(bucket_next_ + n_),
        last_member_(hashes_ + n_) {
    std::fill(head_, bucket_next_, kNone);
    result_.order = Array<Row>(n_);
    result_.starts = Array<Row>(n_ + 1, 0);
    for (mask_ = 1; 2 * mask_ <= n_;) mask_ *= 2;
    --mask_;
    read(pattern);
  }

  Elimination eliminate() {
    while (eliminated_ < n_) {
      if (epoch_ > std::numeric_limits<Place>::max() - 4 * n_) forget_marks();
      take_pivot();
      form_element();
      measure_overlaps();
      update_members();
      merge_equal_members();
      put_back_members();
    }
    finish();
    return std::move(result_);
  }

 private:
  // A vertex: a variable, an element later on, or gone. One half of a cache line holds it: visits
  // come in no order, and memory is what they wait for.
  struct Node {
    Place start;   // of its list
    Row length;    // of its list: a variable's elements, then its variables; an element's members
    Row elements;  // how many of them are elements; an element's place in the order
    Row size;    // vertices that a variable stands for: 0 once absorbed, < 0 in the current element
    Row degree;  // approximate degree of a variable; an element's number of vertices
    Place mark;  // of an element: epoch + |Le \ Lp|, or 0 once absorbed
    Row after;   // its neighbours in the list of variables of one degree; the element that absorbed
                 // it
    Row before;
  };

  void read(const Pattern& pattern) {
    for (Index i = 0; i < n_; ++i) {
      Node& its = nodes_[i];
      last_member_[i] = static_cast<Row>(i);
      its.start = static_cast<Place>(end_);
      for (Index p = pattern.indptr[i]; p < pattern.indptr[i + 1]; ++p)
        if (pattern.indices[p] != i) lists_[end_++] = pattern.indices[p];
      its.length = its.degree = static_cast<Row>(end_ - its.start);
      its.size = 1;
      its.elements = 0;
      its.mark = 1;
      its.after = its.before = kNone;
    }
    // Nearly dense rows are ordered last: they cause the same fill anywhere and are expensive to
    // update.
    const Row full = static_cast<Row>(std::max(16.0, 10 * std::sqrt(static_cast<double>(n_))));
    for (Row i = static_cast<Row>(n_ - 1); i >= 0; --i) {
      if (nodes_[i].degree > full) {
        ++result_.n_full;
        ++eliminated_;
        nodes_[i].size = 0;
        result_.order[n_ - result_.n_full] = i;
      } else {
        push(i);
      }
    }
  }

  // Put a variable in front of those of its degree.
  void push(Row i) {
    Node& its = nodes_[i];
    its.after = head_[its.degree];
    its.before = kNone;
    if (its.after != kNone) nodes_[its.after].before = i;
    head_[its.degree] = i;
  }

  void forget_marks() {
    epoch_ = 2;
    for (Node& node : nodes_) node.mark = node.mark != 0;
  }

  void take_pivot() {
    while (head_[least_] == kNone) ++least_;
    pivot_ = head_[least_];
    Node& own = nodes_[pivot_];
    follower_ = own.after;  // the next pivot, most of the time
    head_[least_] = follower_;
    if (follower_ != kNone) {
      nodes_[follower_].before = kNone;
      prefetch(&nodes_[follower_]);
    }
    pivot_size_ = own.size;
    eliminated_ += pivot_size_;
    own.size = -pivot_size_;
  }

  // The element Lp: the variables of the pivot, and those of its elements, which it absorbs.
  void form_element() {
    Node& own = nodes_[pivot_];
    const Row count = own.elements;
    Index needed = own.length - count;
    for (Index p = own.start; p < own.start + count; ++p) needed += nodes_[lists_[p]].length;
    if (end_ + needed > lists_.size()) move_lists(needed);
    Row* const lists = lists_.data();
    first_ = end_;
    members_ = 0;
    Index end = end_;
    for (Row q = 0; q <= count; ++q) {
      const bool last = q == count;
      const Row e = last ? pivot_ : lists[own.start + q];
      Node& element = nodes_[e];
      const Index begin = element.start, stop = begin + element.length;
      for (Index p = last ? begin + count : begin; p < stop; ++p) {
        const Row i = lists[p];
        Node& its = nodes_[i];
        const Row size = its.size;
        if (size <= 0) continue;
        members_ += size;
        its.size = -size;
        lists[end++] = i;
        prefetch(lists + its.start);
        if (its.before != kNone)
          nodes_[its.before].after = its.after;
        else
          head_[its.degree] = its.after;
        if (its.after != kNone) nodes_[its.after].before = its.before;
      }
      if (!last) absorb(element);
    }
    end_ = end;
    own.elements = 0;
    own.start = static_cast<Place>(first_);
    own.length = static_cast<Row>(end_ - first_);
  }

  void absorb(Node& element) {
    element.mark = 0;
    element.length = 0;
    element.after = pivot_;
  }

  void move_lists(Index needed) {
    Index live = 0;
    for (const Node& node : nodes_) live += node.length;
    Array<Row> moved(live + needed + lists_.size() / 2);
    end_ = 0;
    for (Node& node : nodes_) {
      std::copy_n(&lists_[node.start], node.length, &moved[end_]);
      node.start = static_cast<Place>(end_);
      end_ += node.length;
    }
    lists_ = std::move(moved);
  }

  // |Le \ Lp| for every element e that touches Lp.
  void measure_overlaps() {
    const Row* const lists = lists_.data();
    const Index epoch = ++epoch_;
    if (follower_ != kNone) prefetch(lists + nodes_[follower_].start);
    for (Index k = first_; k < end_; ++k) {
      const Node& its = nodes_[lists[k]];
      const Row size = -its.size;
      for (Index p = its.start; p < its.start + its.elements; ++p) {
        Node& element = nodes_[lists[p]];
        const Index left = element.mark;
        if (left >= epoch)
          element.mark = static_cast<Place>(left - size);
        else if (left != 0)
          element.mark = static_cast<Place>(element.degree + epoch - size);
      }
    }
  }

  // Build the new lists and the approximate degrees of the members.
  void update_members() {
    Node& own = nodes_[pivot_];
    Row* const lists = lists_.data();
    const Index epoch = epoch_;
    for (Index k = first_; k < end_; ++k) {
      const Row i = lists[k];
      Node& its = nodes_[i];
      const Index begin = its.start, stop = begin + its.length, variables = begin + its.elements;
      Index outside = 0, fold = 0, keep = begin;
      for (Index p = begin; p < variables; ++p) {
        const Row e = lists[p];
        Node& element = nodes_[e];
        const Index left = element.mark;
        if (left > epoch) {
          outside += left - epoch;
          fold += e;
          lists[keep++] = e;
        } else if (left != 0) {  // all of e lies in the new element
          absorb(element);
        }
      }
      const Index kept = keep - begin;
      for (Index p = variables; p < stop; ++p) {
        const Row j = lists[p];
        const Row size = nodes_[j].size;
        if (size <= 0) continue;
        outside += size;
        fold += j;
        lists[keep++] = j;
      }
      if (keep == begin) {  // nothing but the new element: eliminated along with the pivot
        const Row size = its.size;
        pivot_size_ -= size;
        eliminated_ -= size;
        members_ += size;
        its.size = its.length = 0;
        join(pivot_, i);
        continue;
      }
      its.degree = static_cast<Row>(std::min<Index>(its.degree, outside));
      // The new element goes first. Its place was that of an element or a variable which is there
      // no longer, as it brought i into Lp.
      if (keep > begin + kept) lists[keep] = lists[begin + kept];
      if (kept > 0) lists[begin + kept] = lists[begin];
      lists[begin] = pivot_;
      its.elements = static_cast<Row>(kept + 1);
      its.length = static_cast<Row>(keep - begin + 1);
      const Row key = static_cast<Row>((fold + pivot_) & mask_);
      hashes_[i] = key;
      bucket_next_[i] = bucket_[key];
      bucket_[key] = i;
    }
    own.degree = static_cast<Row>(members_);
    largest_ = std::max(largest_, members_);
    if (follower_ != kNone) {
      const Node& upcoming = nodes_[follower_];
      for (Index p = upcoming.start; p < upcoming.start + upcoming.length; ++p)
        prefetch(&nodes_[lists[p]]);
    }
  }

  // Append the vertices that are eliminated with j to those eliminated with i.
  void join(Row i, Row j) {
    next_member_[last_member_[i]] = j;
    last_member_[i] = last_member_[j];
  }

  // Members with equal lists become one variable.
  void merge_equal_members() {
    epoch_ += largest_ + 1;  // past every mark that this pivot has left
    for (Index k = first_; k < end_; ++k) {
      if (nodes_[lists_[k]].size == 0) continue;
      const Row key = hashes_[lists_[k]];
      Row i = bucket_[key];
      bucket_[key] = kNone;
      for (; i != kNone && bucket_next_[i] != kNone; i = bucket_next_[i]) merge_into(i);
    }
    ++epoch_;
  }

  // Merge into i the variables behind it in its bucket that have the same lists.
  void merge_into(Row i) {
    const Row* const lists = lists_.data();
    const Index epoch = ++epoch_;
    Node& its = nodes_[i];
    const Row length = its.length, count = its.elements;
    for (Index p = its.start + 1; p < its.start + length; ++p)
      nodes_[lists[p]].mark = static_cast<Place>(epoch);
    Row previous = i;
    for (Row j = bucket_next_[i], following; j != kNone; j = following) {
      Node& other = nodes_[j];
      bool same = other.length == length && other.elements == count;
      for (Index p = other.start + 1; same && p < other.start + length; ++p)
        same = nodes_[lists[p]].mark == epoch;
      following = bucket_next_[j];
      if (same) {
        its.size += other.size;
        other.size = other.length = 0;
        join(i, j);
        bucket_next_[previous] = following;
      } else {
        previous = j;
      }
    }
  }

  // Put the members back into the lists of degrees, and remove the pivot from them.
  void put_back_members() {
    Node& own = nodes_[pivot_];
    Row* const lists = lists_.data();
    const Index left = n_ - eliminated_, members = members_;
    Index end = first_;
    for (Index k = first_; k < first_ + own.length; ++k) {
      const Row i = lists[k];
      Node& its = nodes_[i];
      const Row size = -its.size;
      if (size == 0) continue;
      its.size = size;
      its.degree =
          static_cast<Row>(std::max<Index>(std::min<Index>(its.degree + members, left) - size, 0));
      push(i);
      least_ = std::min(least_, its.degree);
      lists[end++] = i;
    }
    end_ = end;
    own.length = static_cast<Row>(end - first_);
    own.size = pivot_size_;
    if (end == first_) own.mark = 0;
    own.after = kNone;
    own.elements = static_cast<Row>(n_groups_);
    for (Row v = pivot_; v != kNone; v = next_member_[v]) result_.order[ordered_++] = v;
    result_.starts[++n_groups_] = static_cast<Row>(ordered_);
  }

  void finish() {
    const Index n_groups = n_groups_ + (result_.n_full > 0);
    result_.heights = Array<Row>(n_groups);
    result_.parents = Array<Row>(n_groups);
    const Row after = result_.n_full ? static_cast<Row>(n_groups_) : kNone;
    for (Index g = 0; g < n_groups_; ++g) {
      if (g + kPrefetchDistance < n_groups_)
        prefetch(&nodes_[result_.order[result_.starts[g + kPrefetchDistance]]]);
      const Node& element = nodes_[result_.order[result_.starts[g]]];
      result_.heights[g] = element.size + element.degree;
      result_.parents[g] = element.after == kNone ? after : nodes_[element.after].elements;
    }
    if (result_.n_full) {
      result_.heights[n_groups_] = static_cast<Row>(result_.n_full);
      result_.parents[n_groups_] = kNone;
      result_.starts[n_groups] = static_cast<Row>(n_);
    }
    result_.starts.shorten(n_groups + 1);
  }

  const Index n_;
  Array<Node> nodes_;
  Array<Row> lists_;
  Array<Row> links_;        // one piece, so that its pages are large:
  Row* const head_;         // the first variable of a degree
  Row* const bucket_;       // members by a hash of their lists
  Row* const next_member_;  // what is eliminated together
  Row *const bucket_next_, *const hashes_, *const last_member_;
  Elimination result_;
  Index mask_ = 0, end_ = 0, first_ = 0, epoch_ = 2, members_ = 0, largest_ = 0;
  Index eliminated_ = 0, ordered_ = 0, n_groups_ = 0;
  Row pivot_ = kNone, follower_ = kNone, pivot_size_ = 0, least_ = 0;
};

}  // namespace

Elimination minimum_degree(const Pattern& pattern) {
  const Index workspace = 2 * static_cast<Index>(pattern.indices.size()) + 2 * pattern.size() + 64;
  if (workspace < std::numeric_limits<Row>::max()) return QuotientGraph<Row>(pattern).eliminate();
  return QuotientGraph<Index>(pattern).eliminate();
}

}  // namespace geodesic
