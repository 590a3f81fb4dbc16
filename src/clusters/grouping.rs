//! Groups of neighbouring clusters.
//!
//! Pairs that share the largest part of their boundary are merged first, round by round, up to the wanted size (heavy-edge
//! matching, Karypis and Kumar 1998, "A fast and high quality multilevel scheme for partitioning irregular graphs").
//! Vertices held at one level make the boundary between groups dense, so the next level takes it inside.

use std::cmp::Reverse;

use crate::spatial::curve_order;

/// Largest size of a group, over the wanted one.
const EXCESS: f64 = 4.0 / 3.0;
/// Share of the wanted size below which groups join others nearby, also without a common edge.
const SMALL: f64 = 0.5;

/// A group of clusters, or several merged ones while groups form.
struct Node {
    members: Vec<u32>,
    /// Number of boundary edges, all of them counted once.
    n_edges: u64,
}

/// Number of common edges of two nodes, the smaller number first.
#[derive(Clone, Copy)]
struct ClusterLink {
    nodes: [u32; 2],
    n_edges: u64,
}

/// Joins clusters in groups of about `wanted` each.
///
/// `edges` holds the boundary edges of each cluster as sorted pairs of places; `center` is a cluster's center.
pub fn group_clusters(
    edges: &[Vec<[u32; 2]>],
    center: impl Fn(u32) -> [f32; 3] + Sync,
    wanted: usize,
) -> Vec<Vec<u32>> {
    let mut nodes: Vec<Node> = (0u32..)
        .zip(edges)
        .map(|(cluster, edges)| Node { members: vec![cluster], n_edges: edges.len() as u64 })
        .collect();
    let mut links = find_links(edges);
    let most = (wanted as f64 * EXCESS) as usize;
    loop {
        let n_before = nodes.len();
        (nodes, links) = merge_best_pairs(nodes, &links, most);
        if nodes.len() == n_before {
            break;
        }
    }
    let groups = nodes.into_iter().map(|node| node.members).collect();
    join_small(groups, &center, wanted)
}

/// Counts the common edges of each pair of clusters.
fn find_links(edges: &[Vec<[u32; 2]>]) -> Vec<ClusterLink> {
    let owner =
        |(cluster, edges): (u32, &Vec<[u32; 2]>)| edges.iter().map(move |&edge| (edge, cluster)).collect::<Vec<_>>();
    let mut owners: Vec<([u32; 2], u32)> = (0u32..).zip(edges).flat_map(owner).collect();
    owners.sort_unstable();
    let mut pairs: Vec<[u32; 2]> = Vec::with_capacity(owners.len() / 2);
    for owners in owners.chunk_by(|x, y| x.0 == y.0) {
        // Non-manifold edges link each cluster with the next.
        pairs.extend(owners.windows(2).map(|pair| [pair[0].1, pair[1].1]));
    }
    sum_links(pairs.into_iter().filter(|[a, b]| a != b).map(|nodes| ClusterLink { nodes, n_edges: 1 }).collect())
}

fn sum_links(mut links: Vec<ClusterLink>) -> Vec<ClusterLink> {
    links.sort_unstable_by_key(|link| link.nodes);
    let sum = |links: &[ClusterLink]| ClusterLink {
        nodes: links[0].nodes,
        n_edges: links.iter().map(|link| link.n_edges).sum(),
    };
    links.chunk_by(|x, y| x.nodes == y.nodes).map(sum).collect()
}

/// Merges pairs of at most `most` clusters, those first whose common edges are the largest share of a boundary.
fn merge_best_pairs(nodes: Vec<Node>, links: &[ClusterLink], most: usize) -> (Vec<Node>, Vec<ClusterLink>) {
    let fits = |link: &&ClusterLink| {
        let [a, b] = link.nodes.map(|node| nodes[node as usize].members.len());
        a + b <= most
    };
    // Shares are compared as whole numbers, so that no rounding decides.
    let share = |link: &ClusterLink| {
        let [a, b] = link.nodes.map(|node| nodes[node as usize].n_edges.max(1));
        (link.n_edges.pow(2) << 20) / (a * b)
    };
    let size = |link: &ClusterLink| link.nodes.iter().map(|&node| nodes[node as usize].members.len()).sum::<usize>();
    let mut candidates: Vec<&ClusterLink> = links.iter().filter(fits).collect();
    // Small groups come first, so that sizes stay even.
    candidates.sort_unstable_by_key(|link| (size(link).ilog2(), Reverse(share(link)), link.nodes));
    let mut merged_into: Vec<u32> = (0..nodes.len() as u32).collect();
    let mut is_taken = vec![false; nodes.len()];
    let mut n_inner_edges = vec![0; nodes.len()];
    for link in candidates {
        let [a, b] = link.nodes;
        if !is_taken[a as usize] && !is_taken[b as usize] {
            (is_taken[a as usize], is_taken[b as usize]) = (true, true);
            merged_into[b as usize] = a;
            n_inner_edges[a as usize] = 2 * link.n_edges;
        }
    }
    renumber(nodes, links, &merged_into, &n_inner_edges)
}

fn renumber(
    nodes: Vec<Node>,
    links: &[ClusterLink],
    merged_into: &[u32],
    n_inner_edges: &[u64],
) -> (Vec<Node>, Vec<ClusterLink>) {
    let mut numbers: Vec<u32> = Vec::with_capacity(nodes.len());
    let mut merged: Vec<Node> = Vec::with_capacity(nodes.len());
    for ((v, node), &n_inner) in nodes.into_iter().enumerate().zip(n_inner_edges) {
        let target = merged_into[v] as usize;
        // A node merges into one of a smaller number, which has its new number already.
        if target == v {
            numbers.push(merged.len() as u32);
            merged.push(Node { n_edges: node.n_edges.saturating_sub(n_inner), ..node });
        } else {
            let number = numbers[target];
            numbers.push(number);
            let target = &mut merged[number as usize];
            target.n_edges += node.n_edges;
            target.members.extend(node.members);
        }
    }
    let renumbered = links.iter().map(|link| {
        let [a, b] = link.nodes.map(|node| numbers[node as usize]);
        ClusterLink { nodes: [a.min(b), a.max(b)], ..*link }
    });
    (merged, sum_links(renumbered.filter(|link| link.nodes[0] != link.nodes[1]).collect()))
}

/// Joins groups far below the wanted size with others near them, such as those of separate components.
fn join_small(groups: Vec<Vec<u32>>, center: &(impl Fn(u32) -> [f32; 3] + Sync), wanted: usize) -> Vec<Vec<u32>> {
    let is_small = |group: &Vec<u32>| (group.len() as f64) < SMALL * wanted as f64;
    let (small, mut groups): (Vec<_>, Vec<_>) = groups.into_iter().partition(is_small);
    let mean_center = |group: u32| {
        let members = &small[group as usize];
        members
            .iter()
            .map(|&member| center(member))
            .fold([0.0; 3], |sum: [f32; 3], p| std::array::from_fn(|k| sum[k] + p[k] / members.len() as f32))
    };
    let mut joined: Vec<u32> = Vec::new();
    for group in curve_order(small.len(), mean_center, || ()) {
        joined.extend(&small[group as usize]);
        if joined.len() >= wanted {
            groups.push(std::mem::take(&mut joined));
        }
    }
    match groups.last_mut() {
        // The rest of the curve is near the group that ended before it.
        Some(last) if !joined.is_empty() && is_small(&joined) && last.len() <= wanted => last.extend(joined),
        _ if !joined.is_empty() => groups.push(joined),
        _ => (),
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    // Clusters as the cells of a grid, four edges each.
    fn grid(n: u32) -> Vec<Vec<[u32; 2]>> {
        let corner = |x: u32, y: u32| y * (n + 1) + x;
        let cell = |i: u32| {
            let (x, y) = (i % n, i / n);
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x, y + 1), corner(x + 1, y + 1)];
            vec![[a, b], [a, c], [b, d], [c, d]]
        };
        (0..n * n).map(cell).collect()
    }

    fn cell_center(n: u32) -> impl Fn(u32) -> [f32; 3] {
        move |i| [(i % n) as f32, (i / n) as f32, 0.0]
    }

    #[test]
    fn groups_hold_each_cluster_once_and_have_about_the_wanted_size() {
        for n in [1, 2, 7, 20] {
            let groups = group_clusters(&grid(n), cell_center(n), 8);
            let mut all: Vec<u32> = groups.iter().flatten().copied().collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..n * n));
            assert!(groups.iter().all(|group| group.len() <= 18), "{n}");
            assert!(groups.len() <= (n * n) as usize / 5 + 1, "{n}: {}", groups.len());
        }
    }

    #[test]
    fn clusters_without_a_common_edge_are_grouped_with_near_ones() {
        let apart: Vec<Vec<[u32; 2]>> = (0..40).map(|i| vec![[3 * i, 3 * i + 1], [3 * i, 3 * i + 2]]).collect();
        let groups = group_clusters(&apart, |i| [i as f32, 0.0, 0.0], 8);
        assert_eq!(groups.len(), 5);
        assert!(groups.iter().all(|group| group.iter().max().unwrap() - group.iter().min().unwrap() == 7));
    }

    #[test]
    fn long_boundaries_come_inside() {
        // Four clusters in a row; the middle boundary is dense.
        let edges = |from: u32, n: u32| (from..from + n).map(|v| [v, v + 1]);
        let row = [
            edges(0, 2).collect(),
            edges(0, 2).chain(edges(100, 30)).collect(),
            edges(100, 30).chain(edges(200, 2)).collect(),
            edges(200, 2).collect(),
        ];
        let groups = group_clusters(&row, |i| [i as f32, 0.0, 0.0], 2);
        assert!(groups.iter().any(|group| group == &[1, 2]), "{groups:?}");
    }
}
