//! Probe.
use fem_core::{assembly::System, body::Body, boundary::BoundaryConditions, dof::DofMap, interface::*, material::*, mesh::generate::block, cholesky::*};
use std::{sync::Arc, time::Instant};
fn main() {
    let a: Vec<usize> = std::env::args().skip(1).map(|s| s.parse().unwrap()).collect();
    let (nx, ny, runs) = (a[0], a[1], a[2]);
    let m = LinearElastic::isotropic(2000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [nx, ny]).unwrap(), m.clone(), &BoundaryConditions::new().displace("top", Some(0.0.into()), Some((-0.01).into()))).unwrap();
    let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [nx, 1]).unwrap(), m, &BoundaryConditions::new().fix("bottom")).unwrap();
    let i = ContactInterface::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    if a.len() > 3 {
        rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap().install(|| {
            for _ in 0..runs {
                let t = Instant::now();
                let mk = || System::with_dofs(&upper, DofMap::new(&upper, &i.sides()[0])).unwrap();
                let (s1, s2) = rayon::join(mk, mk);
                let t1 = t.elapsed();
                let t = Instant::now();
                let an = |s: &System| Arc::new(SymbolicCholesky::analyse(&s.stiffness, s.dofs.fronts()).unwrap());
                let (a1, a2) = rayon::join(|| an(&s1), || an(&s2));
                let t2 = t.elapsed();
                let t = Instant::now();
                let (_c1, _c2) = rayon::join(|| Cholesky::factorise(a1, &s1.stiffness).unwrap(), || Cholesky::factorise(a2, &s2.stiffness).unwrap());
                println!("both: assembly {t1:?} symbolic {t2:?} factor {:?}", t.elapsed());
            }
        });
        return;
    }
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| {
    for _ in 0..runs {
        let t = Instant::now();
        let d = DofMap::new(&upper, &i.sides()[0]);
        let t0 = t.elapsed();
        let t = Instant::now();
        let s = System::with_dofs(&upper, d).unwrap();
        let t1 = t.elapsed();
        let t = Instant::now();
        let sym = Arc::new(SymbolicCholesky::analyse(&s.stiffness, s.dofs.fronts()).unwrap());
        let t2 = t.elapsed();
        let t = Instant::now();
        let c = Cholesky::factorise(sym.clone(), &s.stiffness).unwrap();
        let t3 = t.elapsed();
        let mut x = vec![1.0; c.dimension()];
        let t = Instant::now();
        c.forward(&mut x);
        let t4 = t.elapsed();
        let t = Instant::now();
        c.backward(&mut x, 0);
        let t5 = t.elapsed();
        println!("order {t0:?} assembly {t1:?} symbolic {t2:?} factor {t3:?} forward {t4:?} backward {t5:?} fronts {} Gop {:.3} rate {:.1} values {:.1}M peak {:.1}M", s.dofs.fronts().len(), sym.operations()/1e9, sym.operations()/1e9/t3.as_secs_f64(), sym.stored_values() as f64/1e6, sym.peak_values() as f64/1e6);
    }});
}
