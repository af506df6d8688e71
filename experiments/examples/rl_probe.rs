use dragnet_agent::agent::Agent;
use dragnet_learn::network::Network;
use dragnet_learn::policy::{Gnn, PolicyName, Shipped};
use dragnet_learn::reinforcement::Explorer;
use dragnet_learn::weights::Weights;
use dragnet_search::policy::Policy;
use dragnet_sim::simulation::End;
use dragnet_sim::{episode, mixture};
use std::sync::{Arc, mpsc};
fn main() {
    let net = match std::env::args().nth(1) {
        Some(p) if p != "-" => Arc::new(Network::new(&Weights::load(p.as_ref()).unwrap())),
        _ => Shipped::Tour.network(),
    };
    let mut base: Vec<f64> = vec![];
    for t in [0.0, 0.1, 0.25, 0.5, 1.0] {
        let start = std::time::Instant::now();
        let mut cells = vec![];
        for seed in 6000..6150_u32 {
            let s = mixture::scenario(seed).unwrap();
            if s.robots().len() > 1 { continue; }
            let s = s.with_policy(PolicyName::Learned(Shipped::Tour)).unwrap();
            let (sink, _keep) = mpsc::channel();
            let mut robots = episode::team(&s, seed.into(), |c| {
                let p: Box<dyn Policy + Send> = if t == 0.0 { Box::new(Gnn::new(net.clone())) } else { Box::new(Explorer::new(net.clone(), t, sink.clone())) };
                Agent::with_policy(c, p)
            });
            let e = episode::run_robots(&s, seed.into(), End::AllFound, &mut robots).unwrap();
            cells.push(e.outcome.cells_to_full_recall.unwrap_or(s.budget_cells()).min(s.budget_cells()));
        }
        let n = cells.len() as f64;
        let m = cells.iter().sum::<f64>() / n;
        if base.is_empty() { base = cells.clone(); }
        let d: Vec<f64> = cells.iter().zip(&base).map(|(a, b)| a - b).collect();
        let dm = d.iter().sum::<f64>() / n;
        let se = (d.iter().map(|x| (x - dm).powi(2)).sum::<f64>() / n / n).sqrt();
        let logr = cells.iter().zip(&base).map(|(a, b)| (a / b).ln()).sum::<f64>() / n;
        println!("T {t}: {m:.1}, diff {dm:.1} +- {se:.1}, mean log ratio {:.3}, {:.0} s", logr, start.elapsed().as_secs_f64());
    }
}
