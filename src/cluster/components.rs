//! Weak and strong components of the cluster graph. A frame outside the strong component it is wanted in leads
//! into a dead end.
//!
//! Plain code over the edge table: a dataflow's `iterate` costs hundreds of times as much (DATAFLOW 5).

use super::tables::Edge;

/// Components of each node, each named by the lowest node number in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    /// The nodes, ascending.
    pub nodes: Vec<u32>,
    /// Strong component: nodes that lead to each other.
    pub strong: Vec<u32>,
    /// Weak component: nodes connected by edges in whatever direction.
    pub weak: Vec<u32>,
}

/// Components of the graph of these nodes.
///
/// `nodes` ascending and distinct; an edge to a node that is not among them is ignored.
pub fn components(nodes: &[u32], edges: &[Edge]) -> Components {
    let mut links: Vec<[usize; 2]> = edges
        .iter()
        .filter_map(|edge| Some([nodes.binary_search(&edge.from_node).ok()?, nodes.binary_search(&edge.to_node).ok()?]))
        .collect();
    links.sort_unstable();
    let named = |of: Vec<usize>| of.into_iter().map(|lowest| nodes[lowest]).collect();
    Components {
        nodes: nodes.to_vec(),
        strong: named(strong(nodes.len(), &links)),
        weak: named(weak(nodes.len(), &links)),
    }
}

/// Share of all frames that lies in the largest component; 0 without frames.
///
/// `components`, `frames`: one entry a node.
pub fn largest_share(components: &[u32], frames: &[u64]) -> f64 {
    let mut sums: Vec<(u32, u64)> = components.iter().copied().zip(frames.iter().copied()).collect();
    sums.sort_unstable();
    let largest = sums.chunk_by(|a, b| a.0 == b.0).map(|part| part.iter().map(|(_, n)| n).sum::<u64>()).max();
    let all: u64 = frames.iter().sum();
    if all == 0 { 0.0 } else { largest.unwrap_or(0) as f64 / all as f64 }
}

/// Lowest place in the weak component of each place: union-find, the lower place on top.
fn weak(n: usize, links: &[[usize; 2]]) -> Vec<usize> {
    let mut above: Vec<usize> = (0..n).collect();
    let find = |above: &mut Vec<usize>, mut place: usize| {
        while above[place] != place {
            above[place] = above[above[place]];
            place = above[place];
        }
        place
    };
    for &[from, to] in links {
        let (a, b) = (find(&mut above, from), find(&mut above, to));
        above[a.max(b)] = a.min(b);
    }
    (0..n).map(|place| find(&mut above, place)).collect()
}

/// Lowest place in the strong component of each place: Tarjan's search with a stack of its own. `links` sorted.
fn strong(n: usize, links: &[[usize; 2]]) -> Vec<usize> {
    const UNSEEN: usize = usize::MAX;
    let out = |place: usize| links.partition_point(|link| link[0] < place);
    let mut component = vec![UNSEEN; n];
    let mut order = vec![UNSEEN; n]; // when a place was first seen
    let mut reach = vec![0; n]; // earliest open place that it leads to
    let mut open = Vec::new(); // seen, in no component yet
    let mut path: Vec<(usize, usize)> = Vec::new(); // places from the root down, with their next link
    let mut n_seen = 0;
    for root in 0..n {
        if order[root] == UNSEEN {
            path.push((root, out(root)));
        }
        while let Some(&mut (place, ref mut next)) = path.last_mut() {
            if order[place] == UNSEEN {
                order[place] = n_seen;
                reach[place] = n_seen;
                n_seen += 1;
                open.push(place);
            }
            if let Some(&[_, to]) = links.get(*next).filter(|link| link[0] == place) {
                *next += 1;
                if order[to] == UNSEEN {
                    path.push((to, out(to)));
                } else if component[to] == UNSEEN {
                    reach[place] = reach[place].min(order[to]);
                }
                continue;
            }
            path.pop();
            if let Some(&(parent, _)) = path.last() {
                reach[parent] = reach[parent].min(reach[place]);
            }
            if reach[place] == order[place] {
                // All that was opened since is its component.
                let first = open.iter().rposition(|&other| other == place).unwrap_or(0);
                let lowest = open[first..].iter().copied().min().unwrap_or(place);
                for other in open.drain(first..) {
                    component[other] = lowest;
                }
            }
        }
    }
    component
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::walks::Random;

    fn edges(links: &[(u32, u32)]) -> Vec<Edge> {
        links.iter().map(|&(from_node, to_node)| Edge { from_node, to_node, transitions: 1, clips: 1 }).collect()
    }

    #[test]
    fn a_cycle_and_its_tail() {
        // 10 -> 11 -> 12 -> 10, 12 -> 20 -> 21; 30 alone.
        let all = edges(&[(10, 11), (11, 12), (12, 10), (12, 20), (20, 21)]);
        let found = components(&[10, 11, 12, 20, 21, 30], &all);
        assert_eq!(found.strong, [10, 10, 10, 20, 21, 30]);
        assert_eq!(found.weak, [10, 10, 10, 10, 10, 30]);
        assert_eq!(largest_share(&found.strong, &[5, 5, 10, 10, 9, 1]), 0.5);
        assert_eq!(largest_share(&[], &[]), 0.0);
    }

    #[test]
    fn equals_reachability_on_random_graphs() {
        for seed in 0..200 {
            let mut random = Random(seed);
            let n = 1 + random.below(14);
            let links: Vec<(u32, u32)> =
                (0..random.below(3 * n)).map(|_| (random.below(n) as u32, random.below(n) as u32)).collect();
            let nodes: Vec<u32> = (0..n as u32).collect();
            let found = components(&nodes, &edges(&links));
            let reaches = |both: bool| {
                let mut reach: Vec<Vec<bool>> = (0..n).map(|a| (0..n).map(|b| a == b).collect()).collect();
                for &(from, to) in &links {
                    reach[from as usize][to as usize] = true;
                    reach[to as usize][from as usize] |= both;
                }
                for via in 0..n {
                    for a in 0..n {
                        for b in 0..n {
                            reach[a][b] |= reach[a][via] && reach[via][b];
                        }
                    }
                }
                reach
            };
            let (forward, any) = (reaches(false), reaches(true));
            for a in 0..n {
                let strong = (0..n).find(|&b| forward[a][b] && forward[b][a]);
                assert_eq!(Some(found.strong[a] as usize), strong, "seed {seed}, node {a}");
                let weak = (0..n).find(|&b| any[a][b]);
                assert_eq!(Some(found.weak[a] as usize), weak, "seed {seed}, node {a}");
            }
        }
    }

    #[test]
    fn a_long_path_does_not_overflow_the_stack() {
        let n = 300_000_u32;
        let nodes: Vec<u32> = (0..n).collect();
        let mut links: Vec<(u32, u32)> = (1..n).map(|node| (node - 1, node)).collect();
        assert_eq!(components(&nodes, &edges(&links)).strong, nodes);
        links.push((n - 1, 0));
        assert!(components(&nodes, &edges(&links)).strong.iter().all(|&component| component == 0));
    }
}
